"""Runs: start, follow, put in order, rename, cancel, resume, remove."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

from fastapi import Path
from pydantic import Field, PlainValidator

from app.api.access import WhoDep
from app.api.responses import failures
from app.api.routing import api_router
from app.body_model import PLAIN, Model
from app.context import Context, ContextDep
from app.runs.view import RunView, StartedRun, run_view, started_run
from app.storage.lookup import require_run

router = api_router("runs")

RunId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="name of the run: 32 hexadecimal digits")]
ParameterName = Annotated[str, Field(min_length=1, max_length=64, pattern=PLAIN)]
_Value = bool | int | float | str | list[float] | None


def _plain(value: object) -> object:
    """Return a JSON scalar or list of numbers unchanged; the engine checks it against its parameter."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list) and all(isinstance(one, int | float) for one in value):
        return value
    raise ValueError("must be a number, a list of numbers, text, true, false or null")


ParameterValue = Annotated[object, PlainValidator(_plain, json_schema_input_type=_Value)]
VideoId = Annotated[str, Path(pattern="^[0-9a-f]{64}$", description="SHA-256 of the video")]


class NewRun(Model):
    """Configuration of a run."""

    preset: str = Field("default", max_length=32, pattern=PLAIN)
    parameters: dict[ParameterName, ParameterValue] = Field({}, max_length=200)
    first: int = Field(0, ge=0, le=2**31 - 1)
    stop: int | None = Field(None, ge=1, le=2**31 - 1)
    name: str = Field("", max_length=120, pattern=PLAIN)


class ByHand(Model):
    """Author and name of a run that is drawn by hand."""

    name: str = Field("Drawn by hand", min_length=1, max_length=120, pattern=PLAIN)
    author: str | None = Field(None, min_length=1, max_length=80, pattern=PLAIN)


class NewName(Model):
    """The new name of a run."""

    name: str = Field(min_length=1, max_length=120, pattern=PLAIN)


class Turn(Model):
    """New place of a waiting run in the queue."""

    before: str | None = Field(None, pattern="^[0-9a-f]{32}$")
    """Run that it goes before; null: after all waiting runs."""


class RemovedRuns(Model):
    """Ids of the runs that were removed."""

    removed: list[str]


class Runs(Model):
    """Some runs."""

    runs: list[RunView]


def forget_runs(context: Context, run_ids: Iterable[str]) -> None:
    """Close what this server has open of removed runs."""
    for run_id in run_ids:
        context.evidence.forget(run_id)
        context.scene3d.forget(run_id)


@router.get("/videos/{video_id}/runs", operation_id="list_runs", responses=failures(404))
def list_runs(video_id: VideoId, context: ContextDep) -> Runs:
    """Runs of a video, newest first."""
    return Runs(runs=context.runs.views(context.runs.of_video(video_id)))


@router.post("/videos/{video_id}/runs", operation_id="start_run", status_code=202, responses=failures(404, 409))
def start_run(video_id: VideoId, wanted: NewRun, context: ContextDep) -> StartedRun:
    """Queue a run of the engine."""
    run = context.runs.start(
        video_id,
        preset=wanted.preset,
        parameters=wanted.parameters,
        first=wanted.first,
        stop=wanted.stop,
        name=wanted.name,
    )
    return started_run(run, wanted.parameters)


@router.post(
    "/videos/{video_id}/runs/by-hand", operation_id="start_run_by_hand", status_code=201, responses=failures(404, 409)
)
def start_run_by_hand(video_id: VideoId, context: ContextDep, who: WhoDep, wanted: ByHand) -> RunView:
    """Make an empty run without an engine, for a person to draw tracks in."""
    made = context.sandboxed_imports.create_empty_run(video_id, wanted.name, who.author(wanted.author))
    with context.database.read() as session:
        return run_view(require_run(session, made.id))


@router.get("/run-queue", operation_id="get_run_queue", responses=failures())
def get_run_queue(context: ContextDep) -> Runs:
    """Running and waiting runs of the engine, in the order of their turns."""
    return Runs(runs=context.runs.views(context.runs.queued_runs()))


@router.post("/runs/{run_id}/turn", operation_id="move_run", responses=failures(404, 409))
def move_run(run_id: RunId, wanted: Turn, context: ContextDep) -> RunView:
    """Move a waiting run before another one, or after all of them."""
    return run_view(context.runs.move(run_id, wanted.before))


@router.get("/runs/{run_id}", operation_id="get_run", responses=failures(404))
def get_run(run_id: RunId, context: ContextDep) -> RunView:
    """One run."""
    with context.database.read() as session:
        run = require_run(session, run_id)
    return context.runs.views([run])[0]


@router.delete("/runs/{run_id}", operation_id="remove_run", status_code=204, responses=failures(404, 409))
def remove_run(run_id: RunId, context: ContextDep) -> None:
    """Remove a run, its evidence and its edits."""
    forget_runs(context, context.runs.remove(run_id))


@router.patch("/runs/{run_id}", operation_id="rename_run", responses=failures(404))
def rename_run(run_id: RunId, wanted: NewName, context: ContextDep) -> RunView:
    """Rename a run."""
    return run_view(context.runs.rename(run_id, wanted.name))


@router.delete("/runs/{run_id}/whatifs", operation_id="remove_whatifs", responses=failures(404))
def remove_whatifs(run_id: RunId, context: ContextDep) -> RemovedRuns:
    """Remove all what-ifs of a run that have ended."""
    removed = context.runs.remove_whatifs(run_id)
    forget_runs(context, removed)
    return RemovedRuns(removed=removed)


@router.post("/runs/{run_id}/cancel", operation_id="cancel_run", status_code=202, responses=failures(404))
def cancel_run(run_id: RunId, context: ContextDep) -> RunView:
    """Stop a run; its stored results are kept."""
    return run_view(context.runs.cancel(run_id))


@router.post("/runs/{run_id}/resume", operation_id="resume_run", status_code=202, responses=failures(404, 409))
def resume_run(run_id: RunId, context: ContextDep) -> RunView:
    """Resume a stopped run."""
    return run_view(context.runs.resume(run_id))
