"""Updates a video after its import has failed, was cancelled or waits again."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.events import EventBus
from app.storage.models import Job, Video
from app.videos.view import publish_video
from app.videos.words import in_words

__all__ = ["video_job_failed"]


def video_job_failed(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """Its import has failed; while that waits once more it stays what it is: being imported.

    Args:
        session: writes.
        events: where pages hear of it.
        job: of the kind ``import``.
        state: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence.
    """
    video = None if state == "queued" else session.get(Video, job.subject)
    if video is not None and video.state == "importing":
        video.state = "failed"
        video.error = in_words(video, error or "The import was stopped. Add the video again.")
        publish_video(session, events, video)
