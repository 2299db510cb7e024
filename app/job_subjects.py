"""Updates what a job works on when the job fails, is cancelled or waits again, and when it has a note."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy import delete
from sqlalchemy.orm import Session

from app.events import EventBus
from app.outputs.view import publish_output
from app.runs.view import publish_run
from app.storage.models import Follow, Job, ModelVersion, Output, Run, Video
from app.storage.servers import waiting_note
from app.training.view import publish_model
from app.videos.error_text import with_upload_name
from app.videos.view import publish_video

Subject = Follow | ModelVersion | Output | Run | Video
"""Subjects of jobs."""
NoteSubject = Follow | ModelVersion | Run
"""Subjects that have a note."""


def on_job_failed(
    subject_class: type[Subject], session: Session, events: EventBus, job: Job, state: str, error: str | None
) -> None:
    """Set the state of a job's subject to the job's state, and notify pages.

    The stored results of a run are kept, and it can be resumed. A video whose import waits again stays in the state
    ``importing``. A follow that was dropped meanwhile is deleted together with its job.

    Args:
        subject_class: class of the subjects of this kind of job.
        session: of the writing transaction.
        events: notifies the pages; a page polls for its follow.
        job: the job.
        state: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence; None: no error.
    """
    subject = session.get(subject_class, job.subject)
    match subject:
        case None if subject_class is Follow:
            session.execute(delete(Job).where(Job.id == job.id))
        case Video(state="importing") if state != "queued":
            subject.state = "failed"
            subject.error = with_upload_name(subject, error or "The import was stopped. Add the video again.")
            publish_video(session, events, subject)
        case Run():
            subject.state, subject.error = state, _error_text(session, subject, error)
            subject.note = waiting_note(session, subject.place) if state == "queued" else ""
            publish_run(session, events, subject)
        case Follow():
            run = session.get(Run, subject.run_id)
            subject.state, subject.note, subject.error = state, "", _error_text(session, run, error)
        case Output():
            subject.state, subject.error, subject.finished = state, error, _finished(state)
            publish_output(session, events, subject)
        case ModelVersion():
            subject.state, subject.error, subject.finished = state, error, _finished(state)
            subject.stage = subject.note = ""
            publish_model(session, events, subject)


def on_job_note(subject_class: type[NoteSubject], session: Session, events: EventBus, job: Job, note: str) -> None:
    """Set the note of a job's subject, and notify pages.

    Args:
        subject_class: class of the subjects of this kind of job.
        session: of the writing transaction.
        events: notifies the pages; a page polls for its follow.
        job: the job.
        note: a few words for a progress line; empty: nothing to say.
    """
    subject = session.get(subject_class, job.subject)
    match subject:
        case Run():
            subject.note = note
            publish_run(session, events, subject)
        case Follow():
            subject.note = note
        case ModelVersion():
            subject.note = note
            publish_model(session, events, subject)


def _error_text(session: Session, run: Run | None, error: str | None) -> str | None:
    """A sentence about the video of a run, for the person who added it."""
    video = None if run is None else session.get(Video, run.video_id)
    return error if error is None or video is None else with_upload_name(video, error)


def _finished(state: str) -> datetime | None:
    return None if state == "queued" else datetime.now(UTC)
