"""Finds the run that a job works from; it may have been removed while the job waited."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.storage.models import Run
from tsr_engine.errors import InputError

__all__ = ["run_of_job"]


def run_of_job(session: Session, run_id: str | None) -> Run:
    """The run.

    Args:
        session: reads.
        run_id: as the job or its output names it; None: the database has forgotten it with the run.

    Raises:
        InputError: it has been removed.
    """
    run = None if run_id is None else session.get(Run, run_id)
    if run is None:
        raise InputError("The run has been removed in the meantime.")
    return run
