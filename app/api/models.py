"""Model versions: list, make, promote, roll back, cancel, remove."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path

from app.api.responses import failures
from app.api.routing import api_router
from app.body_model import Model
from app.context import ContextDep
from app.training.request import NewModel
from app.training.sources import TrainingSources
from app.training.view import ModelView

router = api_router("models")

VersionId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="name of the version: 32 hexadecimal digits")]
AnyVersionId = Annotated[
    str, Path(pattern="^([0-9a-f]{32}|shipped)$", description="name of the version; shipped: without any training")
]


class Models(Model):
    """Versions, the newest first; the shipped one is the last."""

    models: list[ModelView]
    active: str | None


@router.get("/models", operation_id="list_models", responses=failures())
def list_models(context: ContextDep) -> Models:
    """All versions, and the one that new runs use."""
    models, active = context.training.list()
    return Models(models=models, active=active)


@router.post("/models", operation_id="train_models", status_code=202, responses=failures(404, 409))
def train_models(wanted: NewModel, context: ContextDep) -> ModelView:
    """Queue the training of a version from current reviews, exports of corrections or public data."""
    return context.training.start(wanted)


@router.post("/models/rollback", operation_id="roll_back_models", responses=failures(409))
def roll_back_models(context: ContextDep) -> ModelView:
    """Revert the last promotion. Returns the version that is active now."""
    return context.training.rollback()


@router.get("/models/sources", operation_id="list_training_sources", responses=failures())
def list_training_sources(context: ContextDep) -> TrainingSources:
    """Reviews and exports that a version can be trained from, and the changes since each export."""
    return context.training.sources()


@router.get("/models/{version_id}", operation_id="get_models", responses=failures(404))
def get_models(version_id: AnyVersionId, context: ContextDep) -> ModelView:
    """One version."""
    return context.training.get(version_id)


@router.post("/models/{version_id}/promote", operation_id="promote_models", responses=failures(404, 409))
def promote_models(version_id: AnyVersionId, context: ContextDep) -> ModelView:
    """Use this version for new runs."""
    return context.training.promote(version_id)


@router.post("/models/{version_id}/cancel", operation_id="cancel_models", status_code=202, responses=failures(404))
def cancel_models(version_id: VersionId, context: ContextDep) -> ModelView:
    """Cancel the training of a version."""
    return context.training.cancel(version_id)


@router.post("/models/{version_id}/resume", operation_id="resume_models", status_code=202, responses=failures(404, 409))
def resume_models(version_id: VersionId, context: ContextDep) -> ModelView:
    """Train a version again that was cancelled or has failed."""
    return context.training.resume(version_id)


@router.delete("/models/{version_id}", operation_id="remove_models", status_code=204, responses=failures(404, 409))
def remove_models(version_id: VersionId, context: ContextDep) -> None:
    """Remove a version that nothing uses."""
    context.training.remove(version_id)
