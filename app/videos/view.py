"""The view of a video for the page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from sqlalchemy import and_, case, func, not_, select
from sqlalchemy.orm import Session

from app.events import EventBus
from app.shapes import Model
from app.storage.latest import latest_last
from app.storage.models import Run, TrackDocument, Video, VideoTag
from app.storage.places import here_of

__all__ = ["ReviewProgress", "VideoView", "publish_video", "video_view", "video_views"]

_AT_ONCE = 500
"""Videos a query; databases take some thousand values in one list."""


class ReviewProgress(Model):
    """How much of the newest complete run people have judged, counted as the queue does.

    ``tracks`` are those that are there: without deleted and merged ones, with those that people made. ``reviewed`` are
    the accepted and rejected ones of them.
    """

    tracks: int
    reviewed: int


class VideoView(Model):
    """One video of the library."""

    id: str
    """SHA-256."""
    name: str
    path: str
    size: int
    """Bytes."""
    state: str
    error: str | None
    missing: bool
    """The file is not there (any more)."""
    sample: bool
    width: int | None
    height: int | None
    pixel_ratio: float
    """Width of a pixel by its height: pictures are shown so, boxes are in stored pixels."""
    frames: int | None
    duration: float | None
    """S."""
    rate: float | None
    codec: str | None
    warnings: list[str]
    created: str
    """ISO 8601."""
    label_set: str | None
    """Key of its own label set; None: the library's default."""
    tags: list[str]
    runs: int
    """Number of runs."""
    latest_run: str | None
    review: ReviewProgress
    """Of the latest complete run: tracks that are there, and those accepted or rejected."""


def video_views(session: Session, videos: Sequence[Video]) -> list[VideoView]:
    """The present state of many videos: two queries a few hundred, so that a library of thousands lists at once."""
    return [view for start in range(0, len(videos), _AT_ONCE) for view in _views(session, videos[start:][:_AT_ONCE])]


def video_view(session: Session, video: Video) -> VideoView:
    """The video's present state."""
    return video_views(session, [video])[0]


def _views(session: Session, videos: Sequence[Video]) -> list[VideoView]:
    ids = [video.id for video in videos]
    counts: Counter[str] = Counter()
    latest: dict[str, tuple[str, int]] = {}
    runs = select(Run.id, Run.video_id, Run.kind, Run.tracks).where(Run.video_id.in_(ids)).order_by(*latest_last())
    for run_id, video_id, kind, tracks in session.execute(runs):
        counts[video_id] += 1
        if kind != "whatif":
            latest[video_id] = run_id, tracks or 0
    # counted by the database: documents of a whole library are too much to read for two numbers
    gone = TrackDocument.document["gone"].as_boolean()
    judged = TrackDocument.document["review"].as_string().in_(["accepted", "rejected"])
    own = not_(TrackDocument.key.startswith("m"))
    more = case((and_(own, not_(gone)), 1), (and_(not_(own), gone), -1), else_=0)
    documents = (
        select(TrackDocument.run_id, func.sum(more), func.sum(case((and_(judged, not_(gone)), 1), else_=0)))
        .where(TrackDocument.run_id.in_([run_id for run_id, _ in latest.values()]))
        .group_by(TrackDocument.run_id)
    )
    edited: dict[str, tuple[int, int]] = {}
    for run_id, change, reviewed in session.execute(documents) if latest else ():
        edited[run_id] = change, reviewed
    tags: dict[str, list[str]] = {}
    given = select(VideoTag.video_id, VideoTag.tag).where(VideoTag.video_id.in_(ids)).order_by(VideoTag.tag)
    for video_id, tag in session.execute(given):
        tags.setdefault(video_id, []).append(tag)
    here = here_of(session)
    return [
        _view(video, tags.get(video.id, []), counts[video.id], latest.get(video.id), edited, here) for video in videos
    ]


def _view(
    video: Video,
    tags: list[str],
    runs: int,
    latest: tuple[str, int] | None,
    edited: Mapping[str, tuple[int, int]],
    here: str | None,
) -> VideoView:
    run_id, tracks = latest or (None, 0)
    more, reviewed = edited.get(run_id, (0, 0)) if run_id else (0, 0)
    return VideoView(
        id=video.id,
        name=video.name,
        path=video.path,
        size=video.size,
        state=video.state,
        error=video.error,
        missing=(here is None or video.place in (None, here)) and not Path(video.path).is_file(),
        sample=video.sample,
        width=video.width,
        height=video.height,
        pixel_ratio=video.pixel_ratio,
        frames=video.frames,
        duration=video.duration,
        rate=video.rate,
        codec=video.codec,
        warnings=list(video.warnings or []),
        created=video.created.isoformat(),
        label_set=video.label_set,
        tags=tags,
        runs=runs,
        latest_run=run_id,
        review=ReviewProgress(tracks=max(0, tracks + more), reviewed=reviewed),
    )


def publish_video(session: Session, events: EventBus, video: Video) -> None:
    """Tell the pages how the video stands."""
    session.flush()
    events.publish(session, "video", video.id, video_view(session, video).model_dump(mode="json"))
