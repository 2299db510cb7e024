"""Edits that tests send to the service, and the content that they leave."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from app.edits.commands import Command, Redo, Undo
from app.edits.views import EditAnswer
from tests.app.edits.edit_services import EditServices
from tests.app.edits.random_commands import initial_documents

__all__ = ["content", "relabel", "send", "undo_or_redo"]

_ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)


def send(
    edits: EditServices, op: str, raw: dict[str, Any], expected: dict[str, int] | None, author: str = "ann"
) -> EditAnswer:
    return edits.service.apply(edits.run, f"op-{op:0>8}", author, _ADAPTER.validate_python(raw), expected)


def undo_or_redo(
    edits: EditServices, op: str, kind: type[Undo] | type[Redo], target: str, author: str = "ann"
) -> EditAnswer:
    name: Any = "undo" if kind is Undo else "redo"
    return edits.service.apply(edits.run, f"op-{op:0>8}", author, kind(name=name, op_id=target), None)


def content(edits: EditServices) -> dict[str, Any]:
    """Documents without revisions, unchanged tracks and removed drawn tracks."""
    fresh = {key: doc.model_dump(exclude={"revision"}) for key, doc in initial_documents().items()}
    docs = {key: doc.model_dump(exclude={"revision"}) for key, doc in edits.documents().items()}
    return {k: d for k, d in docs.items() if d != fresh.get(k) and not (k.startswith("h") and d["gone"])}


def relabel(label: int, key: str = "m1") -> dict[str, Any]:
    return {"name": "relabel_track", "frame": 3, "key": key, "class_id": label}
