"""Tags of videos, to find them by."""

from __future__ import annotations

from collections import defaultdict
from typing import Annotated

from pydantic import AfterValidator, Field
from sqlalchemy import delete, insert, select

from app.body_model import Model
from app.errors import NotFound
from app.events import EventBus
from app.storage.database import Database
from app.storage.lookup import in_parts
from app.storage.models import Video, VideoTag
from app.videos.view import publish_videos


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
    changed: list[str] = []
    with database.write() as session:
        for part in in_parts(list(dict.fromkeys(request.videos))):
            existing = set(session.scalars(select(Video.id).where(Video.id.in_(part))))
            missing = next((video_id for video_id in part if video_id not in existing), None)
            if missing is not None:
                raise NotFound(f"There is no video {missing[:12]}.", field="videos")
            known: defaultdict[str, set[str]] = defaultdict(set)
            for row in session.execute(select(VideoTag.video_id, VideoTag.tag).where(VideoTag.video_id.in_(part))):
                known[row.video_id].add(row.tag)
            new = [
                {"video_id": video_id, "tag": tag}
                for video_id in part
                for tag in dict.fromkeys(request.add)
                if tag not in known[video_id] and tag not in request.remove
            ]
            tagged = {row["video_id"] for row in new}
            changed += [each for each in part if each in tagged or not known[each].isdisjoint(request.remove)]
            if request.remove:
                removed = VideoTag.video_id.in_(part), VideoTag.tag.in_(request.remove)
                session.execute(delete(VideoTag).where(*removed))
            if new:
                session.execute(insert(VideoTag), new)
        publish_videos(session, events, changed)
    return len(changed)
