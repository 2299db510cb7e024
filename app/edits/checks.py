"""Checks an operation before it is stored: revisions, frames, labels and attributes.

Reading a track costs time and memory up to the last frame that its document names, so no edit may name a frame beyond
the end of the video. Documents of older versions are cut when they are read
(:func:`app.edits.effective.effective_track`). Labels and attributes must be those of the video's label set.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Mapping, Sequence

from sqlalchemy.orm import Session

from app.edits.apply import CommandError, apply_command
from app.edits.commands import Command, CreateTrack, Follow, Interpolate, RelabelBox, RelabelTrack, SetAttribute
from app.edits.documents import TrackDoc
from app.edits.history import last_operations
from app.errors import Conflict, Invalid, PreconditionRequired
from app.storage.models import Run, Video
from tsr_engine.labels.model import LabelSet
from tsr_engine.track_table import NO_CLASS


def check_revisions(
    session: Session,
    run_id: str,
    author: str,
    command: Command,
    present: Mapping[str, TrackDoc],
    keys: Sequence[str],
    expected: Mapping[str, int] | None,
) -> None:
    """Refuse a command that was made for other revisions of its tracks.

    Args:
        session: reads the log.
        run_id: the run.
        author: author of the command.
        command: see :mod:`app.edits.commands`.
        present: existing documents of the touched tracks.
        keys: keys of the touched tracks.
        expected: revision of each track that the page knows; unset: none was sent.

    Raises:
        PreconditionRequired: a revision is missing.
        Conflict: a track has changed since; ``details`` holds both versions and its last operation.
    """
    known = expected or {}
    existing = [key for key in keys if key in present]
    missing = [key for key in existing if key not in known]
    if missing:
        raise PreconditionRequired(
            f'Name the revision that the edit is based on: If-Match: "{missing[0]}:{present[missing[0]].revision}".'
        )
    stale = {key: known[key] for key in existing if known[key] != present[key].revision}
    if not stale:
        return
    yours: list[object] = []
    with contextlib.suppress(CommandError):
        yours = [doc.model_dump(mode="json") for doc in apply_command(present, command).values()]
    raise Conflict(
        f"Track {next(iter(stale))} has been changed since you saw it. Look at both versions and decide.",
        code="stale",
        details={
            "current": [present[key].model_dump(mode="json") for key in stale],
            "yours": yours,
            "by": {key: last.model_dump() for key, last in last_operations(session, run_id, author, stale).items()},
        },
    )


def known_frames(session: Session, run: Run) -> int:
    """Return how many frames of a run's video are known.

    After the import all frames are known. Before (the clip of a bundle comes with a complete run) only those that the
    import has decoded or the run has read.

    Raises:
        Conflict: none is known yet.
    """
    video = session.get_one(Video, run.video_id)
    frames = video.frames or 0
    if video.state != "ready":
        frames = max(frames, run.stop or 0)
    if frames < 1:
        raise Conflict(f"{video.name} is {video.state}: its frames are not known yet.", code="not_ready")
    return frames


def require_inside(command: Command, frames: int) -> None:
    """Refuse a command that names frames beyond the video's end.

    Its ``spans`` may reach further, because the server does not read them: they are the page's copy of the engine's
    tracks.

    Raises:
        Invalid: the command names such a frame; the message gives the first one.
    """
    named = {"frame": command.frame}
    if isinstance(command, Interpolate):
        named |= {"first": command.first, "last": command.last}
    if isinstance(command, Follow):
        named |= {"boxes": command.boxes[-1].frame}
    for name, frame in named.items():
        if frame >= frames:
            raise Invalid(_out_of_range(frame, frames), field=f"command.{name}", code="no_such_frame")


def require_documents_inside(documents: Iterable[TrackDoc], frames: int) -> None:
    """Refuse documents with key frames or notes beyond the video's end, from any source.

    Segments may reach further: they only choose among the engine's boxes.

    Raises:
        Invalid: a document does; the message names the track and its last frame.
    """
    for doc in documents:
        last = doc.last_named_frame()
        if last is not None and last >= frames:
            raise Invalid(f"Track {doc.key}: {_out_of_range(last, frames)}", code="no_such_frame")


def resolve_label_key(command: Command, labels: LabelSet) -> Command:
    """Replace the label id of a command by the id of its ``label_key``, because the page may have used another set.

    Raises:
        Invalid: the set has no label with that key.
    """
    if not isinstance(command, CreateTrack | RelabelTrack | RelabelBox):
        return command
    key = command.label_key
    if key is None or command.class_id in (None, NO_CLASS):
        return command
    label = labels.by_key(key)
    if label is None:
        raise Invalid(
            f"The label set '{labels.name}', which the video uses now, has no label {key!r}. Choose one of its labels, "
            "or add it to the set first.",
            field="command.label_key",
            code="no_such_label",
        )
    return command if label.id == command.class_id else command.model_copy(update={"class_id": label.id})


def require_known_labels(docs: Iterable[TrackDoc], labels: LabelSet) -> None:
    """Refuse documents with a label that the set never had; hidden and merged labels are allowed.

    Raises:
        Invalid: a label is unknown; the message names the track and the label.
    """
    known = {NO_CLASS, None, *(label.id for label in labels)}
    for doc in docs:
        for label in (doc.class_id, *(key.class_id for key in doc.keys.values())):
            if label not in known:
                raise Invalid(
                    f"Track {doc.key}: the label set {labels.key!r} has no label {label}. Choose one of its labels, or "
                    "add one to the set first.",
                    field="command.class_id",
                    code="no_such_label",
                )


def require_attribute(
    command: SetAttribute, doc: TrackDoc, labels: LabelSet, engine: Callable[[int], int | None]
) -> None:
    """Refuse an attribute value that the label of a track does not allow.

    Args:
        command: sets the attribute.
        doc: document of the track.
        labels: label set of the video.
        engine: maps an engine track to its label; None: it has none.

    Raises:
        Invalid: the message says what the label allows.
    """
    if command.value is None:
        return
    own_key = doc.keys.get(str(command.frame)) if command.from_here else None
    class_id = doc.class_id if own_key is None or own_key.class_id is None else own_key.class_id
    if class_id is None:
        track = doc.original_track()
        class_id = None if track is None else engine(track)
    label = None if class_id is None else labels.get(labels.resolved(class_id))
    if label is None:
        raise _refused(f"Track {doc.key} has no label of the set {labels.key!r}. Give it one first.", "attribute")
    attribute = label.attribute(command.attribute)
    if attribute is None:
        raise _refused(
            f"The label {label.name!r} has no attribute {command.attribute!r}. Add it to the label first.", "attribute"
        )
    if command.from_here and not attribute.mutable:
        raise _refused(
            f"The attribute {attribute.name!r} of {label.name!r} has one value for the whole track. Set it there.",
            "from_here",
        )
    if (problem := attribute.problem(command.value)) is not None:
        raise _refused(f"The label {label.name!r}: {problem}.", "value")


def _out_of_range(frame: int, frames: int) -> str:
    return f"The video has frames 0 to {frames - 1}. Got {frame}."


def _refused(message: str, field: str) -> Invalid:
    return Invalid(message, field=f"command.{field}", code="no_such_attribute")
