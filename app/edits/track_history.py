"""The history of a track, read from the log: who changed what and when."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.body_model import Model
from app.edits.documents import TrackDoc
from app.storage.lookup import require_run
from app.storage.models import Edit
from tsr_engine.json_shapes import JsonObject

_PAGE_SIZE = 50
_ROWS_PER_QUERY = 200
"""Rows of the log that are read at once; a row can hold many tracks."""
_MAX_ENTRIES = 20
"""Maximum number of boxes, notes and attributes in one difference."""


class Difference(Model):
    """One property before and after."""

    what: str
    """``label``, ``review``, ``boxes``, ``notes`` ...: see :func:`differences`."""
    before: object  # a text, a number, a list or an object of the document
    after: object
    """For boxes, notes and attributes: only those that differ."""
    more: int = 0
    """How many further ones differ."""


class Happened(Model):
    """One operation on the track."""

    seq: int
    author: str
    time: str
    """ISO 8601, UTC, by the clock of the server that stored it; the order is that of ``seq``."""
    name: str
    """Kind of the command, or ``undo`` and ``redo``."""
    frame: int | None
    differences: list[Difference]


class TrackHistory(Model):
    """Operations, newest first."""

    key: str
    happened: list[Happened]
    more: int | None
    """Request rows before this number for older operations; None: there are none."""


def track_history(session: Session, run_id: str, key: str, before: int | None = None) -> TrackHistory:
    """Read the operations on a track of a run, newest first.

    Args:
        session: reads the log.
        run_id: the run.
        key: key of the track.
        before: rows of the log before this number; None: from the newest on.

    Raises:
        NotFound: no such run.
    """
    require_run(session, run_id)
    found: list[Happened] = []
    for row in _rows(session, run_id, key, before):
        if len(found) == _PAGE_SIZE:
            return TrackHistory(key=key, happened=found, more=found[-1].seq)
        old, new = (None if doc is None else TrackDoc.model_validate(doc) for doc in (row.old, row.new))
        found.append(
            Happened(
                seq=row.seq,
                author=row.author,
                time=row.created.isoformat(timespec="seconds"),
                name=row.kind,
                frame=row.frame,
                differences=differences(old, new),
            )
        )
    return TrackHistory(key=key, happened=found, more=None)


def _rows(session: Session, run_id: str, key: str, before: int | None) -> Iterator[Any]:  # Any: rows have no types
    """Operations on a track, newest first; only this track's documents are read from the database."""
    old, new = Edit.before[key].label("old"), Edit.after[key].label("new")
    touched = Edit.after[key, "revision"].as_integer().is_not(None)
    columns = select(Edit.seq, Edit.author, Edit.created, Edit.kind, Edit.frame, old, new)
    query = columns.where(Edit.run_id == run_id, touched).order_by(Edit.seq.desc()).limit(_ROWS_PER_QUERY)
    while True:
        page = session.execute(query if before is None else query.where(Edit.seq < before)).all()
        yield from page
        if len(page) < _ROWS_PER_QUERY:
            return
        before = page[-1].seq


def differences(before: TrackDoc | None, after: TrackDoc | None) -> list[Difference]:
    """Compare the documents of a track before and after an operation; empty: no visible change.

    Args:
        before: the document; None: the track was untouched, or did not exist.
        after: the document.
    """
    old, new = _properties(before), _properties(after)
    if before is None:  # an untouched engine track: its segments are no change of a person
        old["pieces of the engine"] = new["pieces of the engine"]
    return [Difference(what=what, **_before_and_after(old[what], new[what])) for what in old if old[what] != new[what]]


def _before_and_after(old: object, new: object) -> JsonObject:
    """Both sides of a difference; for values with many entries only those that differ."""
    if not (isinstance(old, dict) and isinstance(new, dict)):
        return {"before": old, "after": new}
    keys = [key for key in {**old, **new} if old.get(key) != new.get(key)]
    few = keys[:_MAX_ENTRIES]
    return {
        "before": {key: old[key] for key in few if key in old},
        "after": {key: new[key] for key in few if key in new},
        "more": len(keys) - len(few),
    }


def _properties(doc: TrackDoc | None) -> JsonObject:
    """The properties of a document, each short enough for a list."""
    if doc is None:
        doc = TrackDoc(key="m0")
    labelled = {frame: key for frame, key in doc.keys.items() if key.class_id is not None or key.attributes}
    return {
        "label": doc.class_id,
        "review": doc.review,
        "deleted": doc.gone and doc.merged_into is None,
        "merged into": doc.merged_into,
        "not a sign": doc.not_a_sign,
        "ignore": doc.ignore,
        "attributes": doc.attributes,
        "boxes": {frame: key.box for frame, key in doc.keys.items() if key.box is not None},
        "occluded": sorted(int(frame) for frame, key in doc.keys.items() if key.occluded),
        "ends": sorted(int(frame) for frame, key in doc.keys.items() if key.outside),
        "labels of frames": {frame: (key.class_id, key.attributes) for frame, key in labelled.items()},
        "interpolated": sorted(
            int(frame) for frame, key in doc.keys.items() if key.interpolate and key.box is not None
        ),
        "pieces of the engine": [(piece.track, piece.first, piece.last) for piece in doc.segments],
        "notes": {note.id: f"{note.author}, frame {note.frame}: {note.text}" for note in doc.notes},
    }
