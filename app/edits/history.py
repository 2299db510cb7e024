"""What a person can undo and redo, derived from the log: nothing to keep, nothing to lose on a reload."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.edits.documents import TrackDoc
from app.shapes import Model
from app.storage.models import Edit

__all__ = ["Last", "Target", "adopted_keys", "last_said", "targets"]

_PAGE = 8
_PASSED = 100
"""Operations that somebody else has changed since; beyond them nothing is looked for."""


class Target(Model):
    """The operation that Ctrl+Z or Ctrl+Shift+Z would be about."""

    op_id: str
    name: str
    frame: int | None
    keys: list[str]


def targets(
    session: Session, run_id: str, author: str, fits: Callable[[Mapping[str, Any]], bool] | None = None
) -> tuple[Target | None, Target | None]:
    """What ``author`` can undo and redo next.

    Operations are taken back from the newest one on and brought back in the opposite order, and a new one ends what
    could be brought back. So the next to undo is the newest that does not stand as undone, and the next to redo is the
    last undone one since the newest operation. The log is read backwards, only as far as that takes.

    Args:
        session: reads the log.
        run_id: the run.
        author: whose operations.
        fits: whether tracks still are as an operation left them (key -> document). One that does not fit is passed
            over, so that what somebody else has changed does not bar the way to all that came before; at most
            ``_PASSED`` are. Unset: none is.
    """
    undoable: str | None = None
    stands: dict[str, str] = {}
    reverts_since: list[tuple[str, str]] = []
    fresh = True
    passed = 0
    for op_id, kind, reverted in _backwards(session, run_id, author):
        if reverted is not None:
            stands.setdefault(reverted, kind)
            if fresh:
                reverts_since.append((kind, reverted))
        else:
            fresh = False
            if stands.get(op_id) == "undo":
                continue
            if fits is None or fits(session.scalars(select(Edit.after).where(Edit.op_id == op_id)).one()):
                undoable = op_id
                break
            passed += 1
            if passed > _PASSED:
                break
    undone: list[str] = []
    for kind, reverted in reversed(reverts_since):
        if kind == "undo":
            undone.append(reverted)
        else:
            undone.remove(reverted)
    return _target(session, undoable), _target(session, undone[-1] if undone else None)


def _backwards(session: Session, run_id: str, author: str) -> Iterator[tuple[str, str, str | None]]:
    """Operation, kind, and what it reverts: the author's log from the newest row on, a page at a time."""
    query = (
        select(Edit.seq, Edit.op_id, Edit.kind, Edit.reverts)
        .where(Edit.run_id == run_id, Edit.author == author)
        .order_by(Edit.seq.desc())
    )
    size, before = _PAGE, None
    while True:
        page = session.execute((query if before is None else query.where(Edit.seq < before)).limit(size)).all()
        for seq, op_id, kind, reverts in page:
            before = seq
            yield op_id, kind, reverts
        if len(page) < size:
            return
        size *= 4


def _target(session: Session, op_id: str | None) -> Target | None:
    if op_id is None:
        return None
    columns = select(Edit.kind, Edit.frame, Edit.after).where(Edit.op_id == op_id)
    kind, frame, after = session.execute(columns).one()
    return Target(op_id=op_id, name=kind, frame=frame, keys=sorted(after))


class Last(Model):
    """The newest operation on a track."""

    author: str
    time: str
    """ISO 8601, UTC."""
    name: str
    frame: int | None


def last_said(session: Session, run_id: str, author: str, seen: Mapping[str, int]) -> dict[str, Last]:
    """The newest operation on each of some tracks since somebody saw them: another person's, else their own.

    Args:
        session: reads the log.
        run_id: the run.
        author: who saw them.
        seen: revision of each track then, by key.
    """
    found: dict[str, Last] = {}
    for key, revision in seen.items():
        touched = Edit.run_id == run_id, Edit.after[key, "revision"].as_integer() > revision
        query = select(Edit.author, Edit.created, Edit.kind, Edit.frame).where(*touched)
        row = session.execute(query.order_by((Edit.author != author).desc(), Edit.seq.desc()).limit(1)).first()
        if row is not None:
            time = row.created.isoformat(timespec="seconds")
            found[key] = Last(author=row.author, time=time, name=row.kind, frame=row.frame)
    return found


def adopted_keys(session: Session, run_id: str, from_run: str, present: Mapping[str, TrackDoc]) -> set[str]:
    """Tracks that still are as an adoption from a run, or the undo of one, has left them.

    Args:
        session: reads the log.
        run_id: the run that adopts.
        from_run: the run whose edits come over.
        present: documents of ``run_id``.
    """
    query = select(Edit.op_id, Edit.kind, Edit.command, Edit.reverts, Edit.after).where(Edit.run_id == run_id)
    adoptions: set[str] = set()
    left: dict[str, Any] = {}
    for op_id, kind, command, reverts, after in session.execute(query.order_by(Edit.seq)):
        if kind == "adopt" and command["from_run"] == from_run:
            adoptions.add(op_id)
        if op_id in adoptions or reverts in adoptions:
            left.update(after)
    return {key for key, doc in present.items() if key in left and doc.same(TrackDoc.model_validate(left[key]))}
