"""Puts the note of a job on what it works on."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.events import EventBus
from app.runs.view import publish_run
from app.storage.models import Follow, Job, ModelVersion, Run
from app.training.view import publish_model

NoteSubject = Follow | ModelVersion | Run
"""Subjects that have a note."""


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
