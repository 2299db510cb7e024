"""Finds a run by its id, and the newest number of its log."""

from __future__ import annotations

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.errors import NotFound
from app.storage.models import Edit, Run

__all__ = ["newest_edit", "require_run"]


def require_run(session: Session, run_id: str) -> Run:
    """Return a run.

    Raises:
        NotFound: no such run.
    """
    run = session.get(Run, run_id)
    if run is None:
        raise NotFound(f"There is no run {run_id[:40]!r}.")
    return run


def newest_edit(session: Session, run_id: str) -> int:
    """Number of the newest operation on a run; 0: none yet."""
    return session.scalar(select(func.max(Edit.seq)).where(Edit.run_id == run_id)) or 0
