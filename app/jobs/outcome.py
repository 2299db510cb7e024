"""How a job that did not end well is told to the people who wait for it."""

from __future__ import annotations

from contextlib import suppress

from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.queue import Fenced, JobQueue
from app.jobs.tasks import TaskContext
from app.runs.view import publish_run
from app.storage.models import Job, Run, Video
from app.videos.view import publish_video

__all__ = ["give_back", "report_failure", "settle_subject", "take_back"]


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
    with suppress(Fenced), task.database.write() as session:
        take_back(session, task.events, task.jobs, task.job)


def take_back(session: Session, events: EventBus, jobs: JobQueue, job: Job) -> None:
    """Queue a claimed job again, unharmed; one that a person has cancelled is over.

    Raises:
        Fenced: it belongs to another process.
    """
    if session.get_one(Job, job.id).cancel:
        jobs.finish(session, job.id, job.token, "cancelled")
        settle_subject(session, events, job, "cancelled", None)
    else:
        jobs.release(session, job.id, job.token)
        settle_subject(session, events, job, "queued", None)
