"""The view of a model version for pages."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.body_model import Model, Moment
from app.events import EventBus
from app.labels.store import default_key, newest
from app.storage.models import ModelVersion
from app.training.folders import active_version
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.classes import classes_of_keys
from tsr_engine.labels.model import LabelSet


class ModelView(Model):
    """One version of the model files."""

    id: str
    """Id; `shipped`: the engine's models."""
    name: str
    state: str
    error: str | None
    parent_id: str | None
    lineage: JsonObject
    figures: JsonObject
    models: dict[str, str]
    """Part -> SHA-256."""
    stage: str
    note: str
    """What a worker does for it besides its progress, in a few words; empty: nothing to say."""
    done: int
    total: int | None
    active: bool
    created: Moment
    finished: Moment | None
    labels: int
    """Number of labels that it can classify."""
    lacks: list[str]
    """Names of labels of the library's set that it cannot classify."""


def library_labels(session: Session) -> LabelSet:
    """The library's label set."""
    return newest(session, default_key(session))


def label_facts(keys: list[str] | None, labels: LabelSet) -> JsonObject:
    """Fields of a view about the labels of a model.

    Args:
        keys: keys of its classes; None: those of ``gtsrb-43``.
        labels: the library's set.
    """
    classes = classes_of_keys(keys, labels)
    return {"labels": len(list(classes.numbers())), "lacks": [label.name for label in classes.labels_without_class()]}


def model_view(version: ModelVersion, active: bool, labels: LabelSet) -> ModelView:
    """Convert a version to its view; ``labels`` is the library's set."""
    note = version.note if version.state == "running" else ""
    return ModelView.from_row(version, active=active, note=note, **label_facts(version.lineage.get("labels"), labels))


def publish_model(session: Session, events: EventBus, version: ModelVersion) -> None:
    """Notify pages of the state of a version."""
    session.flush()
    active = active_version(session)
    view = model_view(version, active is not None and active.id == version.id, library_labels(session))
    events.publish(session, "model", version.id, view.model_dump(mode="json"))
