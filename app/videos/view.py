"""The view of a video for the page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from sqlalchemy import ColumnElement, select, true
from sqlalchemy.orm import Session

from app.body_model import Model
from app.events import EventBus
from app.storage.lookup import current_run_last, in_parts
from app.storage.models import ReviewCount, Run, Video, VideoTag
from app.storage.servers import this_server
from app.videos.paths import existing_files
from tsr_engine.json_shapes import JsonObject


class ReviewProgress(Model):
    """Progress of the review of the newest complete run, counted as in the queue.

    ``tracks`` counts existing tracks: without deleted and merged ones, with those that people made. ``reviewed`` counts
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
    """Whether the file is missing."""
    sample: bool
    width: int | None
    height: int | None
    pixel_ratio: float
    """Width of a pixel by its height, for display; boxes are in stored pixels."""
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
    """Review of the latest complete run: existing tracks, and accepted or rejected ones."""


def video_listing(session: Session) -> list[JsonObject]:
    """The fields of all ``VideoView``, newest video first, with a few queries for a library of thousands."""
    return _fields(session, true())


def video_view(session: Session, video: Video) -> VideoView:
    """Convert a video to its view."""
    session.flush()
    return VideoView(**_fields(session, Video.id == video.id)[0])


def _fields(session: Session, wanted: ColumnElement[bool]) -> list[JsonObject]:
    # plain rows, because making objects of 10,000 videos and runs takes longer than sending them
    execute = session.connection().execute
    counts: Counter[str] = Counter()
    latest: dict[str, tuple[str, int, int]] = {}
    runs = (
        select(Run.id, Run.video_id, Run.kind, Run.tracks, ReviewCount.more, ReviewCount.reviewed)
        .join(Video, Video.id == Run.video_id)
        .outerjoin(ReviewCount, ReviewCount.run_id == Run.id)
        .where(wanted)
        .order_by(*current_run_last())
    )
    for run_id, video_id, kind, tracks, more, reviewed in execute(runs):
        counts[video_id] += 1
        if kind != "whatif":
            latest[video_id] = run_id, max(0, (tracks or 0) + (more or 0)), reviewed or 0
    tags: dict[str, list[str]] = {}
    given = select(VideoTag.video_id, VideoTag.tag).join(Video, Video.id == VideoTag.video_id).where(wanted)
    for video_id, tag in execute(given.order_by(VideoTag.tag)):
        tags.setdefault(video_id, []).append(tag)
    rows = execute(select(*_COLUMNS).where(wanted).order_by(Video.created.desc(), Video.name)).all()
    server = this_server(session)
    is_local = [server is None or row.place in (None, server) for row in rows]
    existing = existing_files([row.path for row, is_row_local in zip(rows, is_local, strict=True) if is_row_local])
    found = []
    for row, is_row_local in zip(rows, is_local, strict=True):
        fields: JsonObject = dict(zip(_PLAIN, row, strict=False))
        video_id = fields["id"]
        run, tracks, reviewed = latest.get(video_id, (None, 0, 0))
        fields["missing"] = is_row_local and fields["path"] not in existing
        fields["warnings"] = fields["warnings"] or []
        fields["created"] = fields["created"].isoformat()
        fields["tags"] = tags.get(video_id, [])
        fields["runs"] = counts.get(video_id, 0)
        fields["latest_run"] = run
        fields["review"] = {"tracks": tracks, "reviewed": reviewed}
        found.append(fields)
    return found


_PLAIN = (
    *("id", "name", "path", "size", "state", "error", "sample", "width", "height", "pixel_ratio"),
    *("frames", "duration", "rate", "codec", "warnings", "created", "label_set"),
)
"""Fields that equal a column of the same name."""
_COLUMNS = (*(getattr(Video, name) for name in _PLAIN), Video.place)


def publish_videos(session: Session, events: EventBus, video_ids: Sequence[str]) -> None:
    """Notify pages of the state of many videos, with a few queries for all of them."""
    session.flush()
    for part in in_parts(video_ids):
        found = {fields["id"]: fields for fields in _fields(session, Video.id.in_(part))}
        events.publish_all(session, "video", found)


def publish_video(session: Session, events: EventBus, video: Video) -> None:
    """Notify pages of the state of a video."""
    session.flush()
    events.publish(session, "video", video.id, video_view(session, video).model_dump(mode="json"))
