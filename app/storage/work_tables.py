"""Tables of sums over the log of edits and over the documents; part of ``app.storage.models``.

They hold only derived data: ``app.edits.counters`` updates them in the transaction of each edit, so pages about a whole
library need not read the log.
"""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import BigInteger, Float, ForeignKey, Index, Integer, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base
from app.storage.utc_times import UtcDateTime


class ReviewCount(Base):
    """The numbers of tracks of a run that depend on its documents."""

    __tablename__ = "review_counts"

    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    more: Mapped[int] = mapped_column(Integer, default=0)
    """Number of tracks that people have made, minus the engine's tracks that they have deleted."""
    reviewed: Mapped[int] = mapped_column(Integer, default=0)
    """Number of existing tracks that are accepted or rejected."""


class Verdict(Base):
    """The last verdict of a person on a track, ``accepted`` or ``rejected``, that was not undone."""

    __tablename__ = "verdicts"
    __table_args__ = (Index("verdicts_by_day", "day", "author", "verdict"),)

    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    key: Mapped[str] = mapped_column(String(64), primary_key=True)
    author: Mapped[str] = mapped_column(Text, primary_key=True)
    verdict: Mapped[str] = mapped_column(String(16))
    day: Mapped[int] = mapped_column(Integer)
    """Day, days since 1970 UTC."""


class WorkDay(Base):
    """The operations of a person on a day, by the clocks of the servers that stored them."""

    __tablename__ = "work_days"
    __table_args__ = (Index("work_days_by_seq", "author", "seq"), Index("work_days_by_latest", "latest"))

    author: Mapped[str] = mapped_column(Text, primary_key=True)
    day: Mapped[int] = mapped_column(Integer, primary_key=True)
    """Days since 1970 UTC."""
    seconds: Mapped[float] = mapped_column(Float)
    """Seconds between operations; a pause counts at most the length of a break."""
    seq: Mapped[int] = mapped_column(BigInteger)
    """Number of the last operation in the log."""
    last: Mapped[datetime] = mapped_column(UtcDateTime)
    """Time of the last operation in the log."""
    latest: Mapped[datetime] = mapped_column(UtcDateTime)
    """Latest time of all operations; later than ``last`` if clocks differ."""
    back: Mapped[float] = mapped_column(Float)
    """Largest step back in time in the log, of any person, seconds."""
