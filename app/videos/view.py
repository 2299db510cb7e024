"""A video as pages see it."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from app.events import EventBus
from app.shapes import Model
from app.storage.models import Run, TrackDocument, Video

__all__ = ["ReviewProgress", "VideoView", "publish_video", "video_view"]


class ReviewProgress(Model):
    """How much of the newest complete run people have judged."""

    tracks: int
    reviewed: int


class VideoView(Model):
    """One video; see ``Video`` in static/js/types.js."""

    id: str
    name: str
    path: str
    size: int
    state: str
    error: str | None
    missing: bool
    sample: bool
    width: int | None
    height: int | None
    frames: int | None
    duration: float | None
    rate: float | None
    codec: str | None
    warnings: list[str]
    created: str
    runs: int
    latest_run: str | None
    review: ReviewProgress


def video_view(session: Session, video: Video) -> VideoView:
    """The video's present state."""
    runs = session.scalar(select(func.count()).select_from(Run).where(Run.video_id == video.id)) or 0
    latest = session.scalars(
        select(Run)
        .where(Run.video_id == video.id, Run.kind != "whatif")
        .order_by((Run.state == "complete").desc(), Run.created.desc())
        .limit(1)
    ).first()
    reviewed = 0
    if latest is not None:
        documents = session.scalars(select(TrackDocument.document).where(TrackDocument.run_id == latest.id))
        reviewed = sum(document["review"] != "open" or document["gone"] for document in documents)
    return VideoView(
        id=video.id,
        name=video.name,
        path=video.path,
        size=video.size,
        state=video.state,
        error=video.error,
        missing=not Path(video.path).is_file(),
        sample=video.sample,
        width=video.width,
        height=video.height,
        frames=video.frames,
        duration=video.duration,
        rate=video.rate,
        codec=video.codec,
        warnings=list(video.warnings or []),
        created=video.created.isoformat(),
        runs=runs,
        latest_run=None if latest is None else latest.id,
        review=ReviewProgress(tracks=0 if latest is None else latest.tracks or 0, reviewed=reviewed),
    )


def publish_video(session: Session, events: EventBus, video: Video) -> None:
    """Tell the pages how the video stands."""
    session.flush()
    events.publish(session, "video", video.id, video_view(session, video).model_dump(mode="json"))
