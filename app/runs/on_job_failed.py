"""Updates a run or a what-if after its job has failed, was cancelled or waits again."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.events import EventBus
from app.runs.view import publish_run
from app.storage.models import Job, Run, Video
from app.videos.words import in_words

__all__ = ["run_job_failed"]


def run_job_failed(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """The run stands as its job does; what it has stored stays and can be resumed.

    Args:
        session: writes.
        events: where pages hear of it.
        job: its subject is the run.
        state: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence.
    """
    run = session.get(Run, job.subject)
    if run is not None:
        video = session.get_one(Video, run.video_id)
        run.state, run.error = state, None if error is None else in_words(video, error)
        publish_run(session, events, run)
