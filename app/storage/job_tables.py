"""Tables of work and of what the pages hear of it; part of ``app.storage.models``."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import JSON, BigInteger, Integer, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, Sequence, here, now
from app.storage.moments import Moment
from tsr_engine.json_shapes import JsonObject

__all__ = ["Event", "Job", "Server"]


class Job(Base):
    """Work for a worker process: the durable queue."""

    __tablename__ = "jobs"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    kind: Mapped[str] = mapped_column(String(32))
    """``import``, ``track``, ``whatif`` ..."""
    subject: Mapped[str] = mapped_column(String(64), index=True)
    """The video or run that it works on."""
    payload: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    state: Mapped[str] = mapped_column(String(16), default="queued", index=True)
    """``queued``, ``running``, ``done``, ``failed`` or ``cancelled``."""
    priority: Mapped[int] = mapped_column(Integer, default=0)
    """Higher goes first."""
    token: Mapped[int] = mapped_column(Integer, default=0)
    """Fencing token: rises with every claim; a worker with an older one may write nothing."""
    crashes: Mapped[int] = mapped_column(Integer, default=0)
    """Workers that died in a row without getting further than ``position``."""
    position: Mapped[int | None]
    """How far the job was when a worker died last (a frame)."""
    cancel: Mapped[bool] = mapped_column(default=False)
    place: Mapped[str | None] = mapped_column(String(32), default=here)
    """Server whose workers may do it: the files that it needs lie there."""
    heartbeat: Mapped[datetime | None] = mapped_column(Moment)
    """Changes every few seconds while a process works on the job; PostgreSQL only."""
    error: Mapped[str | None] = mapped_column(Text)
    order: Mapped[int] = mapped_column(BigInteger, default=0, index=True)
    """First come, first served; counts, never a clock."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)
    started: Mapped[datetime | None] = mapped_column(Moment)
    finished: Mapped[datetime | None] = mapped_column(Moment)


class Event(Base):
    """What the pages are informed: a numbered stream that a dropped connection picks up where it broke."""

    __tablename__ = "events"

    seq: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    kind: Mapped[str] = mapped_column(String(32))
    """``video``, ``run``, ``edit``, ``output``, ``model``, ``labels``, ``removed`` ..."""
    subject: Mapped[str] = mapped_column(String(64))
    data: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    time: Mapped[datetime] = mapped_column(Moment, default=now)


class Server(Base):
    """A server with a data folder of its own on a database that several share."""

    __tablename__ = "servers"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    """Random, kept in the data folder."""
    name: Mapped[str] = mapped_column(Text)
    """Machine and data folder, for people."""
    beats: Mapped[int] = mapped_column(BigInteger, default=0)
    """Counts up while it runs."""
