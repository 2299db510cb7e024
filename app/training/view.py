"""A model version as pages see it."""

from __future__ import annotations

from typing import Any

from sqlalchemy.orm import Session

from app.events import EventBus
from app.shapes import Model
from app.storage.models import ModelVersion
from app.training.folders import active_version

__all__ = ["ModelView", "model_view", "publish_model"]


class ModelView(Model):
    """One version; see ``ModelVersion`` in static/js/types.js."""

    id: str
    name: str
    state: str
    error: str | None
    parent_id: str | None
    lineage: dict[str, Any]
    figures: dict[str, Any]
    models: dict[str, str]
    stage: str
    done: int
    total: int | None
    active: bool
    created: str
    finished: str | None


def model_view(version: ModelVersion, active: bool) -> ModelView:
    """The version's present state."""
    return ModelView(
        id=version.id,
        name=version.name,
        state=version.state,
        error=version.error,
        parent_id=version.parent_id,
        lineage=version.lineage,
        figures=version.figures,
        models=version.models,
        stage=version.stage,
        done=version.done,
        total=version.total,
        active=active,
        created=version.created.isoformat(),
        finished=None if version.finished is None else version.finished.isoformat(),
    )


def publish_model(session: Session, events: EventBus, version: ModelVersion) -> None:
    """Tell the pages how the version stands."""
    session.flush()
    active = active_version(session)
    view = model_view(version, active is not None and active.id == version.id)
    events.publish(session, "model", version.id, view.model_dump(mode="json"))
