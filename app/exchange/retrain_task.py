"""The job ``retrain``, and the export of the current reviews that it learns from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.errors import ApiError
from app.exchange.export import ExportRequest, export_sources
from app.exchange.run_sources import run_source
from app.jobs.context import TaskContext
from app.training.task import retrain_models
from tsr_engine.errors import InputError


def retrain(task: TaskContext) -> None:
    """Train a new version of the models, also from current reviews."""
    retrain_models(task, export_reviews)


def export_reviews(task: TaskContext, runs: Sequence[str], out: Path) -> None:
    """Write the current corrections of runs.

    Open tracks are included, because training would otherwise take their places for background.

    Args:
        task: the job; its database is read.
        runs: runs of different videos.
        out: the ZIP file to write.

    Raises:
        InputError: a run was removed, is not complete, or has no results.
    """
    request = ExportRequest(
        runs=list(runs),
        format="tracks-json",
        states=["open", "edited", "accepted", "rejected", "needs_work"],
        not_in_set="class",
    )
    try:
        with task.database.read() as session:
            sources = [run_source(session, task.settings, run) for run in runs]
        export_sources(request, sources, out, zipped=True)
    except ApiError as error:
        raise InputError(error.message) from None
