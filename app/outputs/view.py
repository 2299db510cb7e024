"""The view of an output for the page."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.body_model import Model, Moment
from app.events import EventBus
from app.storage.models import Output
from tsr_engine.json_shapes import JsonObject


class OutputView(Model):
    """One file that was made from runs, or is being made."""

    id: str
    kind: str
    run_id: str | None
    name: str
    """Name of the file."""
    state: str
    error: str | None
    options: JsonObject
    done: int
    total: int | None
    size: int | None
    """Bytes."""
    sha256: str
    summary: JsonObject
    """For an export: title, counts, skipped, skipped_count, videos, split."""
    created: Moment
    finished: Moment | None


def publish_output(session: Session, events: EventBus, output: Output) -> None:
    """Notify pages of the state of an output."""
    session.flush()
    events.publish(session, "artefact", output.id, OutputView.from_row(output).model_dump(mode="json"))
