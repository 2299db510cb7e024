"""Updates an output after its job has failed, was cancelled or waits again."""

from __future__ import annotations

from datetime import UTC, datetime

from sqlalchemy.orm import Session

from app.artefacts.view import publish_artefact
from app.events import EventBus
from app.storage.models import Artefact, Job

__all__ = ["settle_artefact"]


def settle_artefact(session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
    """The artefact stands as its job does.

    Args:
        session: writes.
        events: where pages hear of it.
        job: its subject is the artefact.
        state: ``failed``, ``cancelled`` or ``queued``.
        error: one sentence.
    """
    artefact = session.get(Artefact, job.subject)
    if artefact is not None:
        artefact.state, artefact.error = state, error
        artefact.finished = None if state == "queued" else datetime.now(UTC)
        publish_artefact(session, events, artefact)
