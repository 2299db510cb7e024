"""Reports a failed, cancelled or requeued job to the people who wait for it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from sqlalchemy.orm import Session

from app.jobs.context import TaskContext
from app.jobs.queue import Fenced, JobQueue
from app.storage.models import Job


def notify_subject(session: Session, jobs: JobQueue, job: Job, state: str, error: str | None) -> None:
    """Set the subject of a job to the state of the job, as its kind defines it, and notify pages."""
    kind = jobs.kinds.get(job.kind)
    if kind is not None:
        kind.on_failed(session, jobs.events, job, state, error)


def cancel_subject(session: Session, jobs: JobQueue, subject: str) -> bool:
    """Cancel the jobs of a subject, and notify pages of those that had not started; return whether there were any."""
    cancelled = [job for job in jobs.cancel(session, subject) if job.state == "cancelled"]
    for job in cancelled:
        notify_subject(session, jobs, job, "cancelled", None)
    return bool(cancelled)


def clear_subject(home: Path, jobs: JobQueue, job: Job) -> None:
    """Remove the files of a job that ended without success, as its kind defines it."""
    kind = jobs.kinds.get(job.kind)
    if kind is not None:
        kind.clear(home, job.subject)


def report_failure(task: TaskContext, message: str) -> None:
    """End the job as failed, with one sentence."""
    try:
        with task.database.write() as session:
            task.jobs.finish(session, task.job.id, task.job.token, "failed", message)
            notify_subject(session, task.jobs, task.job, "failed", message)
        clear_subject(task.settings.home, task.jobs, task.job)
    except Fenced:
        pass


def end_stopped_task(task: TaskContext) -> None:
    """End a stopped task: cancelled if a person wanted that, else queued again because the process ends."""
    is_cancelled = False
    with suppress(Fenced), task.database.write() as session:
        is_cancelled = requeue(session, task.jobs, task.job)
    if is_cancelled:
        clear_subject(task.settings.home, task.jobs, task.job)


def requeue(session: Session, jobs: JobQueue, job: Job) -> bool:
    """Queue a claimed job again without counting a crash; True: it was cancelled, so it is over.

    Raises:
        Fenced: it belongs to another process.
    """
    if session.get_one(Job, job.id).cancel:
        jobs.finish(session, job.id, job.token, "cancelled")
        notify_subject(session, jobs, job, "cancelled", None)
        return True
    jobs.release(session, job.id, job.token)
    notify_subject(session, jobs, job, "queued", None)
    return False
