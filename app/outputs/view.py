"""The view of an output for the page."""

from __future__ import annotations

from sqlalchemy.orm import Session

from app.events import EventBus
from app.shapes import Model
from app.storage.models import Output
from tsr_engine.json_shapes import JsonObject

__all__ = ["OutputView", "output_view", "publish_output"]


class OutputView(Model):
    """One file that was made from runs, or is being made."""

    id: str
    kind: str
    run_id: str | None
    name: str
    """Of the file."""
    state: str
    error: str | None
    options: JsonObject
    done: int
    total: int | None
    size: int | None
    """Bytes."""
    sha256: str
    summary: JsonObject
    """Of an export: title, counts, skipped, skipped_count, videos, split."""
    created: str
    finished: str | None


def output_view(output: Output) -> OutputView:
    """The output's present state."""
    return OutputView(
        id=output.id,
        kind=output.kind,
        run_id=output.run_id,
        name=output.name,
        state=output.state,
        error=output.error,
        options=output.options,
        done=output.done,
        total=output.total,
        size=output.size,
        sha256=output.sha256,
        summary=output.summary,
        created=output.created.isoformat(),
        finished=None if output.finished is None else output.finished.isoformat(),
    )


def publish_output(session: Session, events: EventBus, output: Output) -> None:
    """Tell the pages how the output stands."""
    session.flush()
    events.publish(session, "artefact", output.id, output_view(output).model_dump(mode="json"))
