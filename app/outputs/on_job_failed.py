"""Updates an output after its job has failed, was cancelled or waits again."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy.orm import Session

from app.events import EventBus
from app.outputs.view import publish_output
from app.storage.models import Job, Output

__all__ = ["output_job_failed"]


def output_job_failed(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """The output stands as its job does.

    Args:
        session: writes.
        events: where pages hear of it.
        job: its subject is the output.
        state: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence.
    """
    output = session.get(Output, job.subject)
    if output is not None:
        output.state, output.error = state, error
        output.finished = None if state == "queued" else datetime.now(UTC)
        publish_output(session, events, output)
