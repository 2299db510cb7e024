"""How a job that did not end well is told to the people who wait for it."""

from __future__ import annotations

from contextlib import suppress
from datetime import UTC, datetime

from sqlalchemy.orm import Session

from app.artefacts.folders import clear_folder
from app.artefacts.view import publish_artefact
from app.events import EventBus
from app.jobs.context import TaskContext
from app.jobs.queue import Fenced, JobQueue
from app.runs.view import publish_run
from app.storage.models import Artefact, Job, ModelVersion, Run, Video
from app.training.view import publish_model
from app.videos.view import publish_video
from app.videos.words import in_words

__all__ = ["give_back", "report_failure", "settle_subject", "take_back"]


def settle_subject(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """Bring what a job works on to the state that it is left in, and tell the pages.

    Args:
        session: writes.
        events: where pages hear of it.
        job: that has ended, or waits again.
        state: of the run or artefact: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence.
    """
    if job.kind == "import":
        if state == "queued":
            return  # it stays what it is: being imported
        video = session.get(Video, job.subject)
        if video is not None and video.state == "importing":
            video.state = "failed"
            video.error = in_words(video, error or "The import was stopped. Add the video again.")
            publish_video(session, events, video)
        return
    run = session.get(Run, job.subject)
    if run is not None:
        video = session.get_one(Video, run.video_id)
        run.state, run.error = state, None if error is None else in_words(video, error)
        publish_run(session, events, run)
    artefact = session.get(Artefact, job.subject)
    if artefact is not None:
        artefact.state, artefact.error = state, error
        artefact.finished = None if state == "queued" else datetime.now(UTC)
        publish_artefact(session, events, artefact)
    version = session.get(ModelVersion, job.subject)
    if version is not None:
        version.state, version.error, version.stage = state, error, ""
        version.finished = None if state == "queued" else datetime.now(UTC)
        publish_model(session, events, version)


def report_failure(task: TaskContext, message: str) -> None:
    """End the job as failed with one sentence."""
    try:
        with task.database.write() as session:
            task.jobs.finish(session, task.job.id, task.job.token, "failed", message)
            settle_subject(session, task.events, task.job, "failed", message)
        clear_folder(task.settings.home, task.job.subject)
    except Fenced:
        pass


def give_back(task: TaskContext) -> None:
    """A task has stopped as it was asked to: cancelled by a person, or given back because the process ends."""
    over = False
    with suppress(Fenced), task.database.write() as session:
        over = take_back(session, task.events, task.jobs, task.job)
    if over:
        clear_folder(task.settings.home, task.job.subject)


def take_back(session: Session, events: EventBus, jobs: JobQueue, job: Job) -> bool:
    """Queue a claimed job again, unharmed; one that a person has cancelled is over: True.

    Raises:
        Fenced: it belongs to another process.
    """
    if session.get_one(Job, job.id).cancel:
        jobs.finish(session, job.id, job.token, "cancelled")
        settle_subject(session, events, job, "cancelled", None)
        return True
    jobs.release(session, job.id, job.token)
    settle_subject(session, events, job, "queued", None)
    return False
