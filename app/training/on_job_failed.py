"""What becomes of a model version whose job does not end well."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy.orm import Session

from app.events import EventBus
from app.storage.models import Job, ModelVersion
from app.training.view import publish_model

__all__ = ["version_job_failed"]


def version_job_failed(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """The version stands as its job does.

    Args:
        session: writes.
        events: where pages hear of it.
        job: its subject is the version.
        state: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence.
    """
    version = session.get(ModelVersion, job.subject)
    if version is not None:
        version.state, version.error, version.stage = state, error, ""
        version.finished = None if state == "queued" else datetime.now(UTC)
        publish_model(session, events, version)
