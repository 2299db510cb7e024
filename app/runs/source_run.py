"""Finds the run that a job works from; it may have been removed while the job waited."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.storage.models import Run
from tsr_engine.errors import InputError


def run_of_job(session: Session, run_id: str | None) -> Run:
    """Return the run of a job.

    Args:
        session: reads.
        run_id: the run in the job or its output; None: the reference was removed with the run.

    Raises:
        InputError: the run was removed.
    """
    run = None if run_id is None else session.get(Run, run_id)
    if run is None:
        raise InputError("The run has been removed in the meantime.")
    return run
