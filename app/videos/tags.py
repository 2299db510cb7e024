"""Tags of videos, to find them by."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field
from sqlalchemy import delete, select

from app.body_model import Model
from app.errors import NotFound
from app.events import EventBus
from app.storage.database import Database
from app.storage.models import Video, VideoTag
from app.videos.view import publish_video


def _trimmed(tag: str) -> str:
    tag = " ".join(tag.split())
    if not tag:
        raise ValueError("a tag has at least one letter")
    return tag


Tag = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[^\x00-\x1f\x7f,]+$"), AfterValidator(_trimmed)]
"""At most 60 characters, without commas."""


class TagRequest(Model):
    """Tags to add to videos and to remove from them."""

    videos: Annotated[list[Annotated[str, Field(pattern="^[0-9a-f]{64}$")]], Field(min_length=1, max_length=10_000)]
    add: Annotated[list[Tag], Field(max_length=50)] = Field([])
    remove: Annotated[list[Tag], Field(max_length=50)] = Field([])


def change_tags(database: Database, events: EventBus, request: TagRequest) -> int:
    """Add and remove tags of all videos or of none.

    Returns:
        Number of videos that have changed.

    Raises:
        NotFound: no such video.
    """
    changed = 0
    with database.write() as session:
        for video_id in dict.fromkeys(request.videos):
            video = session.get(Video, video_id)
            if video is None:
                raise NotFound(f"There is no video {video_id[:12]}.", field="videos")
            known = set(session.scalars(select(VideoTag.tag).where(VideoTag.video_id == video_id)))
            removed = [tag for tag in request.remove if tag in known]
            new = [tag for tag in dict.fromkeys(request.add) if tag not in known and tag not in request.remove]
            if not removed and not new:
                continue
            if removed:
                session.execute(delete(VideoTag).where(VideoTag.video_id == video_id, VideoTag.tag.in_(removed)))
            session.add_all(VideoTag(video_id=video_id, tag=tag) for tag in new)
            publish_video(session, events, video)
            changed += 1
    return changed
