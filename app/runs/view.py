"""The view of a run for the page."""

from __future__ import annotations

from collections.abc import Mapping

from sqlalchemy.orm import Session

from app.body_model import Model, Moment
from app.events import EventBus
from app.storage.models import Run, Video
from app.videos.view import publish_video
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params.aliases import current_settings, rename_warnings


class RunView(Model):
    """One run over a video."""

    id: str
    video_id: str
    kind: str
    name: str
    parent_id: str | None
    state: str
    error: str | None
    preset: str
    parameters: JsonObject
    """Parameters that differ from the preset."""
    first: int
    stop: int | None
    frames_done: int
    frames_total: int | None
    rate: float | None
    """Frames per second."""
    remaining: float | None
    """S."""
    note: str
    """What a worker does for it besides its progress, in a few words; empty: nothing to say."""
    tracks: int | None
    """Confirmed tracks."""
    engine_version: str
    models: dict[str, str]
    summary: JsonObject
    """Of a complete run; `focus`: its camera's focus of expansion, null or {x, y: shares of the picture, named: by
    a person}; of a what-if: `identical_frames`, `missing_pixels` in `missing_frames` that the evidence lacks,
    `difference`.
    """
    created: Moment
    finished: Moment | None


class StartedRun(RunView):
    """A new run in the queue."""

    warnings: list[str]
    """One sentence for each parameter with an old name."""


def run_view(run: Run) -> RunView:
    """Convert a run to its view."""
    remaining = None
    if run.state == "running" and run.rate and run.frames_total is not None:
        remaining = max(0, run.frames_total - run.frames_done) / run.rate
    note = run.note if run.state in ("queued", "running") else ""
    return RunView.from_row(run, parameters=current_settings(run.parameters), remaining=remaining, note=note)


def started_run(run: Run, parameters: Mapping[str, object]) -> StartedRun:
    """Convert a new run to its view, with a warning for each renamed one of its ``parameters``."""
    return StartedRun(**run_view(run).model_dump(), warnings=rename_warnings(parameters))


def publish_run(session: Session, events: EventBus, run: Run) -> None:
    """Notify pages of the state of a run, and of its video if that depends on the run.

    The view of a video depends on its runs and on which of them is current. Progress changes neither.
    """
    session.flush()
    events.publish(session, "run", run.id, run_view(run).model_dump(mode="json"))
    if run.state != "running":
        publish_video(session, events, session.get_one(Video, run.video_id))
