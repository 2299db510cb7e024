"""Ground truth: import, list, read, remove."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Path, Query

from app.api.responses import failures
from app.context import ContextDep
from app.shapes import Model
from app.storage.models import Truth

__all__ = ["router"]

router = APIRouter(tags=["truths"])

VideoId = Annotated[str, Path(pattern="^[0-9a-f]{64}$", description="SHA-256 of the video")]
TruthId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="32 hexadecimal digits")]
Name = Annotated[str, Path(min_length=1, max_length=120, pattern=r"^[^/\x00-\x1f\x7f]+$")]
Ordinal = Annotated[int, Query(ge=0, le=2**31 - 1)]


class TruthView(Model):
    """One truth of a video."""

    id: str
    name: str
    count: int


class Truths(Model):
    """All truths of a video."""

    truths: list[TruthView]


class TruthBox(Model):
    """One sign in one frame."""

    frame: int
    track: int
    box: tuple[float, float, float, float]
    class_id: int | None
    """None: a sign of no known class."""
    visibility: float
    ignore: bool


class TruthBoxes(Model):
    """A window of frames."""

    boxes: list[TruthBox]


def _view(truth: Truth) -> TruthView:
    return TruthView(id=truth.id, name=truth.name, count=truth.count)


@router.get("/videos/{video_id}/truths", operation_id="list_truths", responses=failures(404))
def list_truths(video_id: VideoId, context: ContextDep) -> Truths:
    """Truths of a video, by name."""
    return Truths(truths=[_view(truth) for truth in context.truths.of_video(video_id)])


@router.put("/videos/{video_id}/truths/{name}", operation_id="put_truth", status_code=201, responses=failures(404))
def put_truth(
    video_id: VideoId, name: Name, content: Annotated[bytes, Body(media_type="text/csv")], context: ContextDep
) -> TruthView:
    """Import a CSV, all of it or nothing; a truth of the same name is replaced."""
    return _view(context.truths.put(video_id, name, content))


@router.get("/truths/{truth_id}/boxes", operation_id="get_truth_boxes", responses=failures(404))
def get_truth_boxes(truth_id: TruthId, first: Ordinal, last: Ordinal, context: ContextDep) -> TruthBoxes:
    """Boxes of ``first <= frame <= last``, at most 256 frames."""
    rows = context.truths.window(truth_id, first, last).tolist()
    return TruthBoxes(
        boxes=[
            TruthBox(
                frame=int(row[0]),
                track=int(row[1]),
                box=(row[2], row[3], row[4], row[5]),
                class_id=None if row[6] < 0 else int(row[6]),
                visibility=row[7],
                ignore=bool(row[8]),
            )
            for row in rows
        ]
    )


@router.delete("/truths/{truth_id}", operation_id="remove_truth", status_code=204, responses=failures(404))
def remove_truth(truth_id: TruthId, context: ContextDep) -> None:
    """Remove one truth."""
    context.truths.remove(truth_id)
