"""Evidence: tracks, lanes, overlays, crops, explanations, and what-ifs."""

from __future__ import annotations

from typing import Annotated

from fastapi import Header, Path, Query
from fastapi.responses import Response
from pydantic import Field

from app.api.responses import CACHED_PNG, cached_png, failures
from app.api.routing import api_router
from app.api.runs import ParameterName, ParameterValue, RunId
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.evidence.crops import CropOf
from app.evidence.explain import Explanation
from app.evidence.gate_flips import Flips
from app.evidence.lane import TrackLane
from app.evidence.overlays import Overlay
from app.evidence.source_lanes import LaneColumns
from app.evidence.tracks import TrackColumns
from app.runs.view import StartedRun, started_run

router = api_router("evidence")

Ordinal = Annotated[int, Query(ge=0, le=2**31 - 1)]
TrackId = Annotated[int, Path(ge=0, le=2**62, description="number of the engine's track")]
Frame = Annotated[int, Path(ge=0, le=2**31 - 1, description="ordinal of the frame")]


class Overlays(Model):
    """A window of frames."""

    overlays: list[Overlay]


class NewWhatIf(Model):
    """Parameters to change, compared with the run that is replayed."""

    parameters: dict[ParameterName, ParameterValue] = Field(min_length=1, max_length=200)
    name: str = Field("", max_length=120, pattern=PLAIN)


def _json_response(content: bytes) -> Response:
    return Response(content, media_type="application/json", headers={"Cache-Control": "no-cache"})


@router.get(
    "/runs/{run_id}/tracks", operation_id="get_tracks", response_model=TrackColumns, responses=failures(404, 409)
)
def get_tracks(run_id: RunId, context: ContextDep) -> Response:
    """The confirmed tracks, one column per property. An unfinished run returns those found so far."""
    return _json_response(context.evidence.tracks(run_id))


@router.get("/runs/{run_id}/lanes", operation_id="get_lanes", response_model=LaneColumns, responses=failures(404, 409))
def get_lanes(run_id: RunId, context: ContextDep) -> Response:
    """The source of each track's result over time."""
    return _json_response(context.evidence.lanes(run_id))


@router.get("/runs/{run_id}/overlays", operation_id="get_overlays", responses=failures(404, 409))
def get_overlays(run_id: RunId, first: Ordinal, last: Ordinal, context: ContextDep) -> Overlays:
    """Contents of the overlay layers in ``first <= frame <= last``, at most 256 frames."""
    return Overlays(overlays=context.evidence.overlays(run_id, first, last))


@router.get("/runs/{run_id}/flips", operation_id="get_flips", responses=failures(404, 409))
def get_flips(
    run_id: RunId, tau: Annotated[float, Query(gt=0, le=1e6, allow_inf_nan=False)], context: ContextDep
) -> Flips:
    """Verdicts of the gate that another tau would change: their number, and the tracks."""
    return context.evidence.flips(run_id, tau)


@router.get("/runs/{run_id}/tracks/{track_id}", operation_id="get_track", responses=failures(404, 409))
def get_track(run_id: RunId, track_id: TrackId, context: ContextDep) -> TrackLane:
    """One track, frame by frame."""
    return context.evidence.track(run_id, track_id)


@router.get(
    "/runs/{run_id}/tracks/{track_id}/crops/{frame}",
    operation_id="get_crop",
    response_class=Response,
    responses=failures(404, 409) | CACHED_PNG,
)
def get_crop(
    run_id: RunId,
    track_id: TrackId,
    frame: Frame,
    context: ContextDep,
    size: Annotated[int, Query(ge=8, le=512, description="longer side, px")] = 96,
    of: CropOf = "result",
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """A track's crop in one frame, with a margin of a tenth of its side. ``of=prediction``: the box that was gated."""
    return cached_png(
        lambda: context.pixels.crop(run_id, track_id, frame, size, of, context.frames.raw),
        f"{run_id}-{track_id}-{frame}-{size}-{of}",
        if_none_match,
    )


@router.get(
    "/runs/{run_id}/tracks/{track_id}/explain/{frame}", operation_id="explain_verdict", responses=failures(404, 409)
)
def explain_verdict(run_id: RunId, track_id: TrackId, frame: Frame, context: ContextDep) -> Explanation:
    """The mirror matches and the two hashes behind one verdict of the gate."""
    return context.pixels.explain(run_id, track_id, frame)


@router.post("/runs/{run_id}/whatif", operation_id="start_whatif", status_code=202, responses=failures(404, 409))
def start_whatif(run_id: RunId, wanted: NewWhatIf, context: ContextDep) -> StartedRun:
    """Replay the run's evidence with other parameters. Returns a new run."""
    return started_run(context.whatif.start(run_id, wanted.parameters, wanted.name), wanted.parameters)
