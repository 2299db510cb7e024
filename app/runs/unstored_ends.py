"""Runs that have ended although their rows say that they run: their end cannot be stored, as on a full disk."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.jobs.locks import unstored_ends
from app.runs.view import RunView, run_view
from app.storage.models import Job, Run


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
    reasons = unstored_ends(home)
    if not reasons:
        return {}  # without a query, because an idle server asks all the time
    jobs = session.execute(select(Job.subject, Job.id).where(Job.id.in_(reasons), Job.state == "running"))
    return {run_id: reasons[job_id] for run_id, job_id in jobs}


def _view(run: Run, reason: str | None) -> RunView:
    if reason is None or run.state != "running":
        return run_view(run)
    note = f"over, but this cannot be stored: {reason}"
    return run_view(run).model_copy(update={"note": note, "rate": None, "remaining": None})
