"""What becomes of a follow whose job does not end well."""

from __future__ import annotations

from sqlalchemy import delete
from sqlalchemy.orm import Session

from app.events import EventBus
from app.storage.models import Follow, Job, Run, Video
from app.videos.words import in_words

__all__ = ["follow_job_failed"]


def follow_job_failed(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """The follow stands as its job does; of one that was dropped meanwhile nothing is left.

    Args:
        session: writes.
        events: unused: the page that waits asks by itself.
        job: its subject is the follow.
        state: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence.
    """
    follow = session.get(Follow, job.subject)
    if follow is None:
        session.execute(delete(Job).where(Job.id == job.id))
        return
    run = session.get(Run, follow.run_id)
    video = None if run is None else session.get(Video, run.video_id)
    follow.state = state
    follow.error = error if error is None or video is None else in_words(video, error)
