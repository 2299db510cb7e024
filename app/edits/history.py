"""What a person can undo and redo, derived from the log: nothing to keep, nothing to lose on a reload."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.edits.documents import TrackDoc
from app.shapes import Model
from app.storage.models import Edit

__all__ = ["Target", "adopted_keys", "stacks", "target"]


class Target(Model):
    """The operation that Ctrl+Z or Ctrl+Shift+Z would be about."""

    op_id: str
    name: str
    frame: int | None
    keys: list[str]


def stacks(session: Session, run_id: str, author: str) -> tuple[list[str], list[str]]:
    """Operations that can be undone and redone, the next one last."""
    query = select(Edit.op_id, Edit.kind, Edit.reverts).where(Edit.run_id == run_id, Edit.author == author)
    done: list[str] = []
    undone: list[str] = []
    for op_id, kind, reverts in session.execute(query.order_by(Edit.seq)):
        if kind == "undo" and reverts is not None:
            done.remove(reverts)
            undone.append(reverts)
        elif kind == "redo" and reverts is not None:
            undone.remove(reverts)
            done.append(reverts)
        else:
            done.append(op_id)
            undone.clear()
    return done, undone


def target(session: Session, stack: list[str]) -> Target | None:
    """The last operation of a stack, described."""
    if not stack:
        return None
    edit = session.scalars(select(Edit).where(Edit.op_id == stack[-1])).one()
    return Target(op_id=edit.op_id, name=edit.kind, frame=edit.frame, keys=sorted(edit.after))


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
