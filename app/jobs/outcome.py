"""How a job that did not end well is told to the people who wait for it."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.queue import Fenced
from app.jobs.tasks import TaskContext
from app.runs.view import publish_run
from app.storage.models import Job, Run, Video
from app.videos.view import publish_video

__all__ = ["give_back", "report_failure", "settle_subject"]


def settle_subject(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """Bring the video or run of an ended job to its state and tell the pages."""
    if job.kind == "import":
        video = session.get(Video, job.subject)
        if video is not None and video.state == "importing":
            video.state, video.error = "failed", error or "The import was stopped. Add the video again."
            publish_video(session, events, video)
        return
    run = session.get(Run, job.subject)
    if run is not None:
        run.state, run.error = state, error
        publish_run(session, events, run)


def report_failure(task: TaskContext, message: str) -> None:
    """End the job as failed with one sentence."""
    try:
        with task.database.write() as session:
            task.jobs.finish(session, task.job.id, task.job.token, "failed", message)
            settle_subject(session, task.events, task.job, "failed", message)
    except Fenced:
        pass


def give_back(task: TaskContext) -> None:
    """A task has stopped as it was asked to: cancelled by a person, or given back because the process ends."""
    try:
        with task.database.write() as session:
            if session.get_one(Job, task.job.id).cancel:
                task.jobs.finish(session, task.job.id, task.job.token, "cancelled")
                settle_subject(session, task.events, task.job, "cancelled", None)
            else:
                task.jobs.release(session, task.job.id, task.job.token)
                settle_subject(session, task.events, task.job, "queued", None)
    except Fenced:
        pass
