"""Runs that have ended although their rows say that they run: their end cannot be stored, as on a full disk."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.jobs.locks import unstored_end
from app.runs.view import RunView, run_view
from app.storage.models import Job, Run

__all__ = ["runs_with_unstored_ends", "views_with_unstored_ends"]


def views_with_unstored_ends(session: Session, home: Path, runs: Sequence[Run]) -> list[RunView]:
    """Views of runs, with a note on each whose end a worker of this data folder cannot store."""
    reasons = _reasons(session, home) if any(run.state == "running" for run in runs) else {}
    return [_view(run, reasons.get(run.id)) for run in runs]


def runs_with_unstored_ends(session: Session, home: Path) -> list[RunView]:
    """Views of the runs whose end a worker of this data folder cannot store, with a note."""
    reasons = _reasons(session, home)
    runs = session.scalars(select(Run).where(Run.id.in_(reasons))) if reasons else ()
    return [_view(run, reasons[run.id]) for run in runs if run.state == "running"]


def _reasons(session: Session, home: Path) -> dict[str, str]:
    """Run -> why its end cannot be stored."""
    running = session.execute(select(Job.subject, Job.id).where(Job.state == "running"))
    return {run_id: reason for run_id, job_id in running if (reason := unstored_end(home, job_id))}


def _view(run: Run, reason: str | None) -> RunView:
    if reason is None or run.state != "running":
        return run_view(run)
    note = f"over, but this cannot be stored: {reason}"
    return run_view(run).model_copy(update={"note": note, "rate": None, "remaining": None})
