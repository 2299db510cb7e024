"""Views of the edits of a run for the page."""

from __future__ import annotations

from app.body_model import Model, Moment
from app.edits.adopt import Adoption
from app.edits.documents import TrackDoc
from app.edits.undo import Target
from app.storage.models import Edit
from tsr_engine.json_shapes import JsonObject


class Annotation(Model):
    """All corrections of a run."""

    seq: int
    """Number of the newest operation."""
    docs: list[TrackDoc]
    undo: Target | None
    """The operation that Ctrl+Z undoes for this author."""
    redo: Target | None


class EditAnswer(Annotation):
    """The answer to one operation; ``docs`` are the touched documents."""

    op_id: str


class AdoptConflict(Model):
    """An edit that could not be carried over."""

    key: str
    reason: str
    frame: int


class Adopted(Model):
    """Result of carrying the edits of another run over."""

    kept: list[str]
    not_needed: list[str]
    conflicts: list[AdoptConflict]


class LogEntry(Model):
    """One row of the log."""

    seq: int
    op_id: str
    author: str
    name: str
    frame: int | None
    reverts: str | None
    command: JsonObject
    keys: list[str]
    time: Moment


def adopted(adoption: Adoption) -> Adopted:
    """Convert an adoption to its view."""
    conflicts = [AdoptConflict(key=key, reason=reason, frame=frame) for key, reason, frame in adoption.conflicts]
    return Adopted(kept=adoption.kept, not_needed=adoption.not_needed, conflicts=conflicts)


def log_entry(edit: Edit) -> LogEntry:
    """Convert a row of the log to its view."""
    return LogEntry.from_row(edit, name=edit.kind, keys=sorted(edit.after), time=edit.created)
