"""The view of an output for the page."""

from __future__ import annotations

from typing import Any

from sqlalchemy.orm import Session

from app.events import EventBus
from app.shapes import Model
from app.storage.models import Artefact

__all__ = ["ArtefactView", "artefact_view", "publish_artefact"]


class ArtefactView(Model):
    """One artefact; see ``Artefact`` in static/js/types.js."""

    id: str
    kind: str
    run_id: str | None
    name: str
    state: str
    error: str | None
    options: dict[str, Any]
    done: int
    total: int | None
    size: int | None
    sha256: str
    summary: dict[str, Any]
    created: str
    finished: str | None


def artefact_view(artefact: Artefact) -> ArtefactView:
    """The artefact's present state."""
    return ArtefactView(
        id=artefact.id,
        kind=artefact.kind,
        run_id=artefact.run_id,
        name=artefact.name,
        state=artefact.state,
        error=artefact.error,
        options=artefact.options,
        done=artefact.done,
        total=artefact.total,
        size=artefact.size,
        sha256=artefact.sha256,
        summary=artefact.summary,
        created=artefact.created.isoformat(),
        finished=None if artefact.finished is None else artefact.finished.isoformat(),
    )


def publish_artefact(session: Session, events: EventBus, artefact: Artefact) -> None:
    """Tell the pages how the artefact stands."""
    session.flush()
    events.publish(session, "artefact", artefact.id, artefact_view(artefact).model_dump(mode="json"))
