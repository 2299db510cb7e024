"""Converts marks of a file (hidden, notes, verdicts) to documents over an imported run.

The evidence of a run is the result of a tracker. The marks come from people: they become the first operation in the log
of the run, with one undo.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from typing import get_args
from uuid import uuid4

import numpy as np

from app.edits.documents import KeyFrame, Note, Review, TrackDoc, engine_doc
from tsr_engine.exchange.attributes import frame_values
from tsr_engine.exchange.dataset import Track

REVIEWS = frozenset(get_args(Review))
_MAX_NOTE_LENGTH = 4000


def marks(tracks: Iterable[Track], numbers: Mapping[str, int], author: str) -> dict[str, tuple[TrackDoc, TrackDoc]]:
    """Make the documents of the tracks with marks: untouched, and with the marks; by key.

    Args:
        tracks: the imported tracks.
        numbers: number of each track in the evidence, by name.
        author: author of the notes.
    """
    found: dict[str, tuple[TrackDoc, TrackDoc]] = {}
    for track in tracks:
        untouched = engine_doc(numbers[track.uid], int(track.frames[0]), int(track.frames[-1]))
        state = track.state if track.state in REVIEWS else "open"
        marked = untouched.model_copy(
            update={
                "review": state,
                "keys": _mark_key_frames(track),
                "notes": new_notes(track.notes, author, untouched),
                "attributes": dict(track.attributes),
                "ignore": is_ignored(track),
            }
        )
        if not marked.has_same_content(untouched):
            found[untouched.key] = untouched, marked
    return found


def new_notes(notes: Iterable[tuple[int, str]], author: str, present: TrackDoc) -> tuple[Note, ...]:
    """Notes of a file that a track does not have yet."""
    known = {(note.frame, note.text) for note in present.notes}
    now = datetime.now(UTC).isoformat(timespec="seconds")
    out: list[Note] = []
    for frame, note in notes:
        # Lone surrogates cannot be stored: replace them.
        text = note.encode("utf-8", "replace").decode()[:_MAX_NOTE_LENGTH]
        if text and (frame, text) not in known:
            known.add((frame, text))
            out.append(Note(id=uuid4().hex, frame=frame, text=text, author=author, time=now))
    return tuple(out)


def is_ignored(track: Track) -> bool:
    """Whether all boxes of a track are to be ignored."""
    return track.ignore is not None and bool(track.ignore.all())


def _mark_key_frames(track: Track) -> dict[str, KeyFrame]:
    """Key frames without a box, where a sign becomes hidden or visible, or its attributes change."""
    changes = np.diff(track.occluded, prepend=np.False_)
    for values in track.changing.values():
        changes[0] |= values[0] is not None
        changes[1:] |= values[1:] != values[:-1]
    return {
        str(track.frames[k]): KeyFrame(occluded=bool(track.occluded[k]), attributes=frame_values(track, k))
        for k in np.flatnonzero(changes).tolist()
    }
