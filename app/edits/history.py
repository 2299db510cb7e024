"""Reads from the log who edited tracks last, and which are as an adoption left them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from sqlalchemy import JSON, bindparam, select
from sqlalchemy.orm import Session

from app.body_model import Model
from app.edits.documents import TrackDoc
from app.storage.models import Edit

_NO_END: Final = 2**62
_PAGE: Final = 32
"""Rows of the log that are read first."""
# built once: building the query takes longer than running it
_EARLIER_OPERATIONS: Final = (
    select(
        Edit.seq,
        Edit.author,
        Edit.created,
        Edit.kind,
        Edit.frame,
        Edit.after[bindparam("key", type_=JSON.JSONStrIndexType())]["revision"].as_integer().label("revision"),
    )
    .where(Edit.run_id == bindparam("run"), Edit.seq < bindparam("before"))
    .order_by(Edit.seq.desc())
    .limit(bindparam("size"))
)


class Last(Model):
    """The newest operation on a track."""

    author: str
    time: str
    """ISO 8601, UTC."""
    name: str
    frame: int | None


def undone_operations(rows: Iterable[tuple[str, str | None]]) -> set[str]:
    """Return operations that were undone and not redone.

    Args:
        rows: kind and reverted operation of each row, in the order of the log.
    """
    found: set[str] = set()
    for kind, reverts in rows:
        if kind == "undo" and reverts is not None:
            found.add(reverts)
        elif kind == "redo" and reverts is not None:
            found.discard(reverts)
    return found


def last_operations(session: Session, run_id: str, author: str, seen: Mapping[str, int]) -> dict[str, Last]:
    """Find the newest operation on each of some tracks since a person saw them; other people's first, else their own.

    Args:
        session: reads the log.
        run_id: the run.
        author: the person.
        seen: revision of each track that the person saw, by key.
    """
    found: dict[str, Last] = {}
    for key, revision in seen.items():
        for row in _since(session, run_id, key, revision):
            if key not in found or row.author != author:
                time = row.created.isoformat(timespec="seconds")
                found[key] = Last(author=row.author, time=time, name=row.kind, frame=row.frame)
            if row.author != author:
                break
    return found


def _since(session: Session, run_id: str, key: str, revision: int) -> Iterator[Any]:  # Any: rows have no types
    """Yield the operations on a track since a revision, newest first; reads no more of the log than needed."""
    before, size = _NO_END, _PAGE
    while rows := session.execute(
        _EARLIER_OPERATIONS, {"run": run_id, "key": key, "before": before, "size": size}
    ).all():
        for row in rows:
            if row.revision is not None and row.revision > revision:
                yield row
            if row.revision is not None and row.revision <= revision + 1:
                return
        before, size = rows[-1].seq, 4 * size


def adopted_keys(session: Session, run_id: str, from_run: str, present: Mapping[str, TrackDoc]) -> set[str]:
    """Find the tracks that are still as an adoption from a run, or its undo, left them.

    Args:
        session: reads the log.
        run_id: the run that adopts.
        from_run: the run whose edits come over.
        present: documents of ``run_id``.
    """
    query = select(Edit.op_id, Edit.kind, Edit.command, Edit.reverts, Edit.after).where(Edit.run_id == run_id)
    adoptions: set[str] = set()
    documents: dict[str, object] = {}
    for op_id, kind, command, reverts, after in session.execute(query.order_by(Edit.seq)):
        if kind == "adopt" and command["from_run"] == from_run:
            adoptions.add(op_id)
        if op_id in adoptions or reverts in adoptions:
            documents.update(after)
    return {
        key
        for key, doc in present.items()
        if key in documents and doc.has_same_content(TrackDoc.model_validate(documents[key]))
    }
