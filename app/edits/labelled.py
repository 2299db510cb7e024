"""Labels and attributes that people give are those of the video's label set."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from app.edits.commands import SetAttribute
from app.edits.documents import NO_CLASS, TrackDoc
from app.errors import Invalid
from tsr_engine.labels.model import LabelSet

__all__ = ["by_key", "require_attribute", "require_known_labels"]


def by_key(command: Any, labels: LabelSet) -> Any:
    """The command with the id that its ``label_key`` has in a set: whoever gave it may have seen another set.

    Args:
        command: see :mod:`app.edits.commands`.
        labels: set of the video.

    Raises:
        Invalid: the set has no label of that key.
    """
    key = getattr(command, "label_key", None)
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
    """Refuse documents with a label that the set has never given out; hidden and merged ones count as given out.

    Args:
        docs: to be stored.
        labels: set of the video.

    Raises:
        Invalid: names the track and the label.
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
    """Refuse a value that the label of a track has no such attribute for.

    Args:
        command: sets the attribute.
        doc: the track that it is about.
        labels: set of the video.
        engine: number of an engine's track -> its label, None: it was never read.

    Raises:
        Invalid: says what the label allows.
    """
    if command.value is None:
        return
    own = doc.keys.get(str(command.frame)) if command.from_here else None
    given = doc.class_id if own is None or own.class_id is None else own.class_id
    if given is None:
        track = doc.began_as()
        given = None if track is None else engine(track)
    label = None if given is None else labels.get(labels.resolved(given))
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


def _refused(message: str, field: str) -> Invalid:
    return Invalid(message, field=f"command.{field}", code="no_such_attribute")
