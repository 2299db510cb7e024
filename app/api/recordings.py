"""Recordings for the Rerun viewer."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from app.api.responses import failures
from app.api.routing import api_router
from app.api.runs import RunId
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.edits.documents import Frame, Key
from app.outputs.view import OutputView

router = api_router("recordings")


class RecordingOrder(Model):
    """Frames and contents of a recording."""

    first: Frame
    stop: Annotated[int, Field(ge=1, le=2**31 - 1, strict=True)]
    name: Annotated[str, Field(max_length=120, pattern=PLAIN)] = ""
    frame: Frame | None = None
    """The frame to show first."""
    track: Key | None = None
    """The track to select."""
    truth: Annotated[str, Field(pattern="^[0-9a-f]{32}$")] | None = None
    """Ground truth to include; unset: the video's, if it has exactly one."""


@router.post("/runs/{run_id}/recordings", operation_id="record_run", status_code=202, responses=failures(404, 409))
def record_run(run_id: RunId, order: RecordingOrder, context: ContextDep) -> OutputView:
    """Record a range of frames as an ``.rrd`` file. Returns the output that will hold it."""
    return context.recordings.start(
        run_id, order.first, order.stop, name=order.name, frame=order.frame, track=order.track, truth=order.truth
    )
