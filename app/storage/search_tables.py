"""Tables of the search across videos, and tags of videos; part of ``app.storage.models``.

The search tables hold only derived data: ``app.search`` makes them from evidence and edits.
"""

from __future__ import annotations

from sqlalchemy import BigInteger, Float, ForeignKey, Index, Integer, String, Text, text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base

_NOTED = text("notes != ''")


class VideoTag(Base):
    """A tag that people have given a video."""

    __tablename__ = "video_tags"

    video_id: Mapped[str] = mapped_column(ForeignKey("videos.id", ondelete="CASCADE"), primary_key=True)
    tag: Mapped[str] = mapped_column(String(60), primary_key=True, index=True)


class SearchRun(Base):
    """A run whose tracks are in the search's tables."""

    __tablename__ = "search_runs"

    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    video_id: Mapped[str] = mapped_column(String(64), index=True)
    basis: Mapped[str] = mapped_column(String(64))
    """Changes with everything besides edits that the rows depend on; see ``app.search.stale``."""
    set_key: Mapped[str] = mapped_column(String(64))
    """Label set of the rows."""
    seq: Mapped[int] = mapped_column(BigInteger)
    """Newest edit that is included in the rows."""
    current: Mapped[bool]
    """Whether it is its video's current run."""
    error: Mapped[str | None] = mapped_column(Text)
    """Why its tracks cannot be read."""
    tracks: Mapped[int] = mapped_column(Integer, default=0, server_default="0")
    """Number of its tracks without regions to ignore, like the next numbers."""
    accepted: Mapped[int] = mapped_column(Integer, default=0, server_default="0")
    rejected: Mapped[int] = mapped_column(Integer, default=0, server_default="0")
    notes: Mapped[int] = mapped_column(Integer, default=0, server_default="0")
    """Number of notes on all its tracks, regions to ignore included."""


class SearchTrack(Base):
    """One track of a run with its corrections and a single box. Deleted tracks have no row."""

    __tablename__ = "search_tracks"
    __table_args__ = (
        Index("search_by_uncertainty", "current", "uncertainty", "run_id", "key"),
        Index("search_by_label", "set_key", "label", "current", "uncertainty"),
        Index("search_by_state", "current", "state", "uncertainty"),
        Index("search_by_state_and_size", "current", "state", "size"),
        Index("search_by_size", "current", "size", "run_id", "key"),
        Index("search_by_notes", "current", "run_id", "key", sqlite_where=_NOTED, postgresql_where=_NOTED),
        Index("search_by_edit", "current", "edited", "run_id", "key"),
    )

    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    key: Mapped[str] = mapped_column(String(64), primary_key=True)
    video_id: Mapped[str] = mapped_column(String(64), index=True)
    current: Mapped[bool]
    """Whether the run is its video's current run."""
    set_key: Mapped[str] = mapped_column(String(64))
    label: Mapped[int] = mapped_column(Integer)
    """Id of a label of the set, as stored, even if the label was merged since. -1: none of the set."""
    state: Mapped[str] = mapped_column(String(16))
    """``open``, ``needs_work``, ``accepted``, ``rejected``, or ``ignored``: a region to ignore."""
    uncertainty: Mapped[float] = mapped_column(Float)
    engine_uncertainty: Mapped[float] = mapped_column(Float)
    """Uncertainty of the engine's track before any edits; 0: drawn by a person, or imported."""
    size: Mapped[float] = mapped_column(Float)
    """Longer side of its largest box, px."""
    frame: Mapped[int] = mapped_column(Integer)
    """Frame of its clearest view: its largest box that lies whole in the picture (the next columns)."""
    x1: Mapped[float] = mapped_column(Float)
    y1: Mapped[float] = mapped_column(Float)
    x2: Mapped[float] = mapped_column(Float)
    y2: Mapped[float] = mapped_column(Float)
    first: Mapped[int] = mapped_column(Integer)
    last: Mapped[int] = mapped_column(Integer)
    revision: Mapped[int] = mapped_column(Integer)
    author: Mapped[str | None] = mapped_column(Text)
    """Author of the last edit; NULL: none."""
    edited: Mapped[int] = mapped_column(BigInteger)
    """Time of the last edit, seconds since 1970 UTC; 0: never."""
    notes: Mapped[str] = mapped_column(Text)
    """Texts of its notes, case folded, one per line; empty: none."""


class SearchAttribute(Base):
    """A value that an attribute has in some frame of a track."""

    __tablename__ = "search_attributes"
    __table_args__ = (Index("search_by_attribute", "name", "value"),)

    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    key: Mapped[str] = mapped_column(String(64), primary_key=True)
    name: Mapped[str] = mapped_column(String(200), primary_key=True)
    value: Mapped[str] = mapped_column(String(200), primary_key=True)
    """The value as text, case folded: ``yes``, ``3.5``, ``rain``; at most 200 characters."""
