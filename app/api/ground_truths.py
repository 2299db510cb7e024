"""Ground truth: import, list, read, remove."""

from __future__ import annotations

from typing import Annotated, Self

from fastapi import Body, Path, Query
from pydantic import Field, model_validator

from app.api.access import WhoDep
from app.api.edits import Author
from app.api.responses import failures
from app.api.routing import api_router
from app.api.runs import RunId, VideoId
from app.body_model import PLAIN, Model
from app.context import ContextDep
from app.edits.documents import ClassId
from app.exchange.take_over import TakenOver

router = api_router("ground truth")

GroundTruthId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="32 hexadecimal digits")]
Name = Annotated[str, Path(min_length=1, max_length=120, pattern=r"^[^/\x00-\x1f\x7f]+$")]
Ordinal = Annotated[int, Query(ge=0, le=2**31 - 1)]


class GroundTruthView(Model):
    """One ground truth of a video."""

    id: str
    name: str
    count: int


class GroundTruths(Model):
    """All ground truths of a video."""

    ground_truths: list[GroundTruthView]


class GroundTruthBox(Model):
    """One sign in one frame."""

    frame: int
    track: int
    box: tuple[float, float, float, float]
    class_id: int | None
    """None: a sign of no known class."""
    visibility: float
    ignore: bool


class GroundTruthBoxes(Model):
    """A window of frames."""

    boxes: list[GroundTruthBox]


class TakeOver(Model):
    """Signs of a ground truth to copy to a run: by number, or all of a label."""

    truth: Annotated[str, Field(pattern="^[0-9a-f]{32}$")]
    signs: Annotated[list[Annotated[int, Field(ge=0, le=2**31 - 1)]], Field(max_length=5000)] = Field([])
    label: ClassId | Annotated[str, Field(min_length=1, max_length=200, pattern=PLAIN)] | None = None
    """Id, key or name; -1: signs of none of the labels."""
    author: Author | None = None

    @model_validator(mode="after")
    def _some(self) -> Self:
        if not self.signs and self.label is None:
            raise ValueError("name signs, or a label")
        return self


@router.get("/videos/{video_id}/ground-truths", operation_id="list_ground_truths", responses=failures(404))
def list_ground_truths(video_id: VideoId, context: ContextDep) -> GroundTruths:
    """Ground truths of a video, by name."""
    found = context.ground_truths.of_video(video_id)
    return GroundTruths(ground_truths=[GroundTruthView.from_row(truth) for truth in found])


@router.put(
    "/videos/{video_id}/ground-truths/{name}", operation_id="put_truth", status_code=201, responses=failures(404)
)
def put_truth(
    video_id: VideoId, name: Name, content: Annotated[bytes, Body(media_type="text/csv")], context: ContextDep
) -> GroundTruthView:
    """Import a CSV, all of it or nothing. A ground truth of the same name is replaced."""
    return GroundTruthView.from_row(context.ground_truths.put(video_id, name, content))


@router.get("/ground-truths/{truth_id}/boxes", operation_id="get_truth_boxes", responses=failures(404))
def get_truth_boxes(truth_id: GroundTruthId, first: Ordinal, last: Ordinal, context: ContextDep) -> GroundTruthBoxes:
    """Boxes in ``first <= frame <= last``, at most 256 frames."""
    rows = context.ground_truths.window(truth_id, first, last).tolist()
    return GroundTruthBoxes(
        boxes=[
            GroundTruthBox(
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


@router.post("/runs/{run_id}/take-over", operation_id="take_over", responses=failures(404, 409))
def take_over(run_id: RunId, wanted: TakeOver, context: ContextDep, who: WhoDep) -> TakenOver:
    """Correct a run with signs of a ground truth, in one operation that one undo reverts."""
    author = who.author(wanted.author)
    return context.take_overs.take(run_id, wanted.truth, author, wanted.signs, wanted.label)


@router.delete("/ground-truths/{truth_id}", operation_id="remove_truth", status_code=204, responses=failures(404))
def remove_truth(truth_id: GroundTruthId, context: ContextDep) -> None:
    """Remove one ground truth."""
    context.ground_truths.remove(truth_id)
