"""Tables of people's work on a run: the log of edits, documents, follows; part of ``app.storage.models``."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import JSON, ForeignKey, Index, Integer, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, Sequence, now
from app.storage.utc_times import UtcDateTime
from tsr_engine.json_shapes import JsonObject


class Edit(Base):
    """One operation of a person on the tracks of a run: a row of the append-only log."""

    __tablename__ = "edits"
    __table_args__ = (
        Index("edits_of_run", "run_id", "seq"),
        Index("edits_of_author", "run_id", "author", "seq"),
        Index("edits_by_author", "author", "seq", "created"),  # holds all columns that hours of work are computed from
        Index("edits_by_kind", "kind", "created"),
    )

    seq: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    op_id: Mapped[str] = mapped_column(String(64), unique=True)
    """Chosen by the page; a repeated operation is one row."""
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"))
    author: Mapped[str] = mapped_column(Text)
    kind: Mapped[str] = mapped_column(String(32))
    """Name of the command, or ``undo`` / ``redo``."""
    command: Mapped[JsonObject] = mapped_column(JSON)
    frame: Mapped[int | None]
    """Current frame of the person's page."""
    before: Mapped[JsonObject] = mapped_column(JSON)
    """Documents of the touched tracks before: key -> document; None: there was none."""
    after: Mapped[JsonObject] = mapped_column(JSON)
    """Documents after, in the same form."""
    reverts: Mapped[str | None] = mapped_column(String(64))
    """Operation that an ``undo`` or ``redo`` applies to."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class TrackDocument(Base):
    """The current document of an edited track."""

    __tablename__ = "track_documents"

    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    key: Mapped[str] = mapped_column(String(64), primary_key=True)
    revision: Mapped[int] = mapped_column(Integer)
    document: Mapped[JsonObject] = mapped_column(JSON)


class Follow(Base):
    """A sign that is being followed for a person; deleted when its proposals are accepted, dropped or abandoned."""

    __tablename__ = "follows"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), index=True)
    author: Mapped[str] = mapped_column(Text)
    key: Mapped[str] = mapped_column(String(64))
    """Track of the proposals."""
    request: Mapped[JsonObject] = mapped_column(JSON)
    """``anchors``, ``only``, ``first``, ``last``."""
    state: Mapped[str] = mapped_column(String(16), default="queued")
    """``queued``, ``running``, ``complete``, ``failed`` or ``cancelled``."""
    error: Mapped[str | None] = mapped_column(Text)
    note: Mapped[str] = mapped_column(Text, default="", server_default="")
    """What a worker does for its job besides its progress, in a few words; empty: nothing to say."""
    endings: Mapped[list[JsonObject]] = mapped_column(JSON, default=list)
    """Why following ended, by direction."""
    pieces: Mapped[int] = mapped_column(Integer, default=0)
    """Number of stored pieces."""
    asked: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
    """Time of the last request of a page."""


class FollowPiece(Base):
    """Some proposals of a follow, in order."""

    __tablename__ = "follow_pieces"

    follow_id: Mapped[str] = mapped_column(ForeignKey("follows.id", ondelete="CASCADE"), primary_key=True)
    number: Mapped[int] = mapped_column(Integer, primary_key=True)
    proposals: Mapped[list[list[object]]] = mapped_column(JSON)
    """Rows of frame, x1, y1, x2, y2, confidence (numbers) and source (a word)."""
