"""Applies commands to documents. Pure; static/js/model/commands.js does the same in the page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import singledispatch
from itertools import pairwise

from app.edits import commands as c
from app.edits.documents import OPEN_END, Box, KeyFrame, Note, Segment, TrackDoc
from app.edits.join import join
from app.edits.relabel import relabelled, with_attribute
from app.edits.split import clip, split

Docs = Mapping[str, TrackDoc]


class CommandError(ValueError):
    """A command that is impossible for the documents; the message is one sentence."""


def touched_keys(command: c.Command) -> list[str]:
    """Keys of the tracks that a command reads or changes."""
    others = list(command.others) if isinstance(command, c.Merge | c.ReviewTracks) else []
    new = [command.new_key] if isinstance(command, c.Split) else []
    return list(dict.fromkeys([command.key, *others, *new]))


def with_class(docs: Docs, command: c.Command, label: Callable[[int], int | None]) -> c.Command:
    """Add the engine's class of the track to a command that may store it (a split or a merge).

    Args:
        docs: documents of at least the touched tracks.
        command: see :mod:`app.edits.commands`.
        label: maps an engine track to its class; None: unknown.
    """
    if not isinstance(command, c.Split | c.Merge):
        return command
    doc = docs.get(command.key)
    if doc is None or doc.class_id is not None:
        return command
    track = doc.original_track()
    return command.model_copy(update={"class_id": None if track is None else label(track)})


def with_gaps(docs: Docs, command: c.Command, gaps: Callable[[int], Iterable[tuple[int, int | None]]]) -> c.Command:
    """Add the frames without a box of the engine's tracks to a merge.

    Args:
        docs: documents of at least the touched tracks.
        command: see :mod:`app.edits.commands`.
        gaps: maps an engine track to the first and last frames of its gaps; None: the gap has no end.
    """
    if not isinstance(command, c.Merge):
        return command
    tracks = {s.track for key in touched_keys(command) if key in docs for s in docs[key].segments}
    found = [
        Segment(track=track, first=first, last=OPEN_END if last is None else last)
        for track in sorted(tracks)
        for first, last in gaps(track)
    ]
    return command.model_copy(update={"gaps": found})


def apply_command(docs: Docs, command: c.Command, author: str = "", time: str = "") -> dict[str, TrackDoc]:
    """Apply a command and return the changed documents; their revisions are not raised yet.

    Args:
        docs: documents of at least the touched tracks; new keys must be missing.
        command: see :mod:`app.edits.commands`.
        author: author of notes.
        time: time of notes, ISO 8601.

    Returns:
        Only the changed documents.

    Raises:
        CommandError: the track does not exist or is deleted, or the command would change nothing.
    """
    if isinstance(command, c.CreateTrack):
        if command.key in docs:
            raise CommandError(f"There is a track {command.key} already.")
        if not command.key.startswith("h"):
            raise CommandError("A new track has a key that starts with h.")
        first = KeyFrame(box=command.box, interpolate=True)
        return {command.key: TrackDoc(key=command.key, class_id=command.class_id, keys={str(command.frame): first})}
    if isinstance(command, c.RestoreTrack):
        return {command.key: _restore(_require_document(docs, command.key))}
    doc = _require_existing(docs, command.key)
    if isinstance(command, c.Merge):
        return _merge(docs, doc, command)
    if isinstance(command, c.ReviewTracks):
        return {key: _set_review(command, _require_existing(docs, key)) for key in touched_keys(command)}
    if isinstance(command, c.Split):
        return _split(docs, doc, command)
    if isinstance(command, c.AddNote):
        return {doc.key: _add_note(doc, command, author, time)}
    if isinstance(command, c.EditNote):
        return {doc.key: _edit_note(doc, command, author, time)}
    return {doc.key: _apply_to_track(command, doc)}


@singledispatch
def _apply_to_track(command: c.Command, doc: TrackDoc) -> TrackDoc:
    """Apply a command that touches one track only."""
    raise NotImplementedError(f"No function applies {command.name}.")


def _require_document(docs: Docs, key: str) -> TrackDoc:
    doc = docs.get(key)
    if doc is None:
        raise CommandError(f"There is no track {key}.")
    return doc


def _require_existing(docs: Docs, key: str) -> TrackDoc:
    doc = _require_document(docs, key)
    if doc.gone:
        raise CommandError(_deletion_reason(doc))
    return doc


def _deletion_reason(doc: TrackDoc) -> str:
    if doc.merged_into is not None:
        return f"Track {doc.key} was merged into track {doc.merged_into}. Change that one, or undo the merge."
    return f"Track {doc.key} is deleted. Restore it first."


def _restore(doc: TrackDoc) -> TrackDoc:
    if not doc.gone:
        raise CommandError(f"Track {doc.key} is not deleted.")
    if doc.merged_into is not None:
        raise CommandError(_deletion_reason(doc))
    if doc.empty():
        raise CommandError(f"Nothing is left of track {doc.key}: what made it was undone.")
    return doc.model_copy(update={"gone": False})


@_apply_to_track.register
def _set_box(command: c.SetBox, doc: TrackDoc) -> TrackDoc:
    return doc.with_key(command.frame, box=command.box, outside=False, followed=False)


@_apply_to_track.register
def _relabel_track(command: c.RelabelTrack, doc: TrackDoc) -> TrackDoc:
    return relabelled(doc, command.class_id)


@_apply_to_track.register
def _relabel_box(command: c.RelabelBox, doc: TrackDoc) -> TrackDoc:
    return doc.with_key(command.frame, class_id=command.class_id, **_shown_box(command, doc))


def _shown_box(command: c.RelabelBox | c.SetOccluded | c.SetOutside | c.SetAttribute, doc: TrackDoc) -> dict[str, Box]:
    """The box of a command's key frame: the displayed one, or else that of a line; nothing: the engine's."""
    box = command.box if command.box is not None else doc.line_at(command.frame)
    return {} if box is None else {"box": box}


@_apply_to_track.register
def _delete_from(command: c.DeleteFrom, doc: TrackDoc) -> TrackDoc:
    if not doc.shows_from(command.frame):
        raise CommandError(f"{_shows_nothing(doc, command.frame)} There is nothing to delete.")
    kept = doc
    for end, box in doc.line_ends(command.frame).items():
        kept = kept.with_key(end, box=box)
    kept = kept.model_copy(
        update={
            "segments": clip(doc.segments, -1, command.frame - 1),
            "keys": {k: key for k, key in kept.keys.items() if int(k) < command.frame},
        }
    )
    return doc.model_copy(update={"gone": True}) if kept.empty() else kept


def _shows_nothing(doc: TrackDoc, frame: int) -> str:
    return f"Track {doc.key} shows nothing from frame {frame} on."


@_apply_to_track.register
def _delete_track(command: c.DeleteTrack, doc: TrackDoc) -> TrackDoc:
    return doc.model_copy(update={"gone": True})


@_apply_to_track.register
def _add_key(command: c.AddKey, doc: TrackDoc) -> TrackDoc:
    return doc.with_key(command.frame, box=command.box, followed=False)


@_apply_to_track.register
def _remove_key(command: c.RemoveKey, doc: TrackDoc) -> TrackDoc:
    if str(command.frame) not in doc.keys:
        raise CommandError(f"Frame {command.frame} is no key frame of track {doc.key}.")
    left = doc.model_copy(update={"keys": {k: key for k, key in doc.keys.items() if k != str(command.frame)}})
    if left.empty():
        raise CommandError("This is the track's only box. Delete the track instead.")
    return left


@_apply_to_track.register
def _interpolate(command: c.Interpolate, doc: TrackDoc) -> TrackDoc:
    inside = [k for k in doc.frames() if command.first <= k <= command.last]
    if len([k for k in inside if doc.keys[str(k)].box is not None]) < 2:
        raise CommandError("Interpolation needs two key frames with a box. Correct the box in two frames first.")
    lines = {str(k): doc.keys[str(k)].model_copy(update={"interpolate": command.value}) for k in inside[:-1]}
    return doc.model_copy(update={"keys": {**doc.keys, **lines}})


@_apply_to_track.register
def _follow(command: c.Follow, doc: TrackDoc) -> TrackDoc:
    """Set followed key frames that are interpolated: earlier followed ones are replaced, a person's are kept."""
    boxes = {entry.frame: entry for entry in command.boxes}
    first, last = command.boxes[0].frame, command.boxes[-1].frame
    hides = next((k for k in doc.frames() if k <= last and doc.keys[str(k)].outside and _until(doc, k) > first), None)
    if hides is not None:
        raise CommandError(
            f"Track {doc.key} is outside from frame {hides} on, as a person says. Follow up to there, or bring it "
            "back first."
        )
    after = doc.last_key(last)
    continues = not doc.segments if after is None else doc.keys[str(after)].interpolate
    keys = {k: key for k, key in doc.keys.items() if not (first <= int(k) <= last and key.followed)}
    key_frames = [KeyFrame(), *(doc.keys[str(k)] for k in doc.frames())]
    changes = {k for k, (a, b) in zip(doc.frames(), pairwise(key_frames), strict=True) if a.attributes != b.attributes}
    for frame in sorted({*boxes, *(k for k in {*changes, *map(int, keys)} if first <= k <= last)}):
        last_before = doc.last_key(frame)
        key_frame = keys.get(str(frame))
        if key_frame is None:
            before = KeyFrame() if last_before is None else doc.keys[str(last_before)]
            key_frame = KeyFrame(occluded=before.occluded, attributes=before.attributes)
        followed = boxes.get(frame)
        if followed is not None:
            key_frame = key_frame.model_copy(update={"box": followed.box, "followed": not followed.anchor})
        keys[str(frame)] = key_frame.model_copy(update={"interpolate": frame < last or continues})
    return doc.model_copy(update={"keys": keys})


def _until(doc: TrackDoc, frame: int) -> int:
    """The next key frame after a frame; without one, a frame beyond all frames."""
    following = doc.next_key(frame)
    return OPEN_END + 1 if following is None else following


@_apply_to_track.register
def _set_occluded(command: c.SetOccluded, doc: TrackDoc) -> TrackDoc:
    return doc.with_key(command.frame, occluded=command.value, **_shown_box(command, doc))


@_apply_to_track.register
def _set_outside(command: c.SetOutside, doc: TrackDoc) -> TrackDoc:
    if command.value and not doc.shows_from(command.frame):
        raise CommandError(f"{_shows_nothing(doc, command.frame)} It is outside already.")
    after = doc.with_key(command.frame, outside=command.value, **_shown_box(command, doc))
    if not command.value and not after.shows_from(command.frame):
        raise CommandError(f"{_shows_nothing(doc, command.frame)} Nothing could come back into view: draw a box.")
    return after


@_apply_to_track.register
def _set_not_a_sign(command: c.SetNotASign, doc: TrackDoc) -> TrackDoc:
    return doc.model_copy(update={"not_a_sign": command.value})


@_apply_to_track.register
def _set_ignore(command: c.SetIgnore, doc: TrackDoc) -> TrackDoc:
    return doc.model_copy(update={"ignore": command.value})


@_apply_to_track.register
def _set_attribute(command: c.SetAttribute, doc: TrackDoc) -> TrackDoc:
    if not command.from_here:
        return with_attribute(doc, command.attribute, command.value, None)
    doc = doc.with_key(command.frame, **_shown_box(command, doc))
    return with_attribute(doc, command.attribute, command.value, command.frame)


@_apply_to_track.register
def _set_review(command: c.SetReview | c.ReviewTracks, doc: TrackDoc) -> TrackDoc:
    return doc.model_copy(update={"review": command.review})


def _add_note(doc: TrackDoc, command: c.AddNote, author: str, time: str) -> TrackDoc:
    if any(note.id == command.note_id for note in doc.notes):
        raise CommandError("There is a note of that name already.")
    note = Note(id=command.note_id, frame=command.frame, text=command.text, author=author, time=time)
    return doc.model_copy(update={"notes": (*doc.notes, note)})


def _edit_note(doc: TrackDoc, command: c.EditNote, author: str, time: str) -> TrackDoc:
    """Change the text of a note; a changed note of another person gets the new author."""
    _require_note(doc, command.note_id)

    def with_text(note: Note) -> Note:
        signed = {} if note.author == author else {"author": author, "time": time}
        return note.model_copy(update={"text": command.text, **signed})

    return doc.model_copy(update={"notes": tuple(with_text(n) if n.id == command.note_id else n for n in doc.notes)})


@_apply_to_track.register
def _remove_note(command: c.RemoveNote, doc: TrackDoc) -> TrackDoc:
    _require_note(doc, command.note_id)
    return doc.model_copy(update={"notes": tuple(n for n in doc.notes if n.id != command.note_id)})


def _require_note(doc: TrackDoc, identity: str) -> None:
    if all(note.id != identity for note in doc.notes):
        raise CommandError("There is no such note (any more).")


def _merge(docs: Docs, doc: TrackDoc, command: c.Merge) -> dict[str, TrackDoc]:
    changed: dict[str, TrackDoc] = {}
    origin = doc.original_track()
    for key in dict.fromkeys(command.others):
        other = docs.get(key)
        if other is None or other.gone or key == doc.key:
            raise CommandError(f"Track {key} cannot be merged: it is gone, or the same track.")
        doc = join(doc, other, command.gaps)
        changed[key] = other.model_copy(update={"gone": True, "merged_into": doc.key})
    if doc.class_id is None and doc.original_track() != origin:  # an earlier segment must not change the label
        doc = doc.model_copy(update={"class_id": command.class_id})
    return {doc.key: doc, **changed}


def _split(docs: Docs, doc: TrackDoc, command: c.Split) -> dict[str, TrackDoc]:
    if command.new_key in docs:
        raise CommandError(f"There is a track {command.new_key} already.")
    halves = split(doc, command.frame, command.new_key, command.class_id)
    if any(half.empty() for half in halves):
        raise CommandError(f"Track {doc.key} has nothing on one side of frame {command.frame}. Split it in between.")
    return {half.key: half for half in halves}
