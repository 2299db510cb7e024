"""Finds a video by its id."""

from __future__ import annotations

from sqlalchemy.orm import Session, undefer

from app.errors import NotFound
from app.storage.models import Video

__all__ = ["require_video"]


def require_video(session: Session, video_id: str, *, table: bool = False) -> Video:
    """Return a video.

    Args:
        session: reads.
        video_id: the video.
        table: also load its frame table.

    Raises:
        NotFound: no such video.
    """
    video = session.get(Video, video_id, options=[undefer(Video.frame_table)] if table else [])
    if video is None:
        raise NotFound(f"There is no video {video_id[:80]!r}.")
    return video
