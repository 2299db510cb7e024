"""Tables of jobs, events and servers; part of ``app.storage.models``."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import JSON, BigInteger, Integer, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, Sequence, current_server, now
from app.storage.utc_times import UtcDateTime
from tsr_engine.json_shapes import JsonObject


class Job(Base):
    """A job for a worker process: the durable queue."""

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
    """Fencing token: rises with every claim; a worker with an older one may not write."""
    crashes: Mapped[int] = mapped_column(Integer, default=0)
    """Number of workers that died in a row without progress beyond ``position``."""
    position: Mapped[int | None]
    """Progress of the job when a worker last died (a frame)."""
    cancel: Mapped[bool] = mapped_column(default=False)
    place: Mapped[str | None] = mapped_column(String(32), default=current_server)
    """Server whose workers may do it, because it has the files."""
    heartbeat: Mapped[datetime | None] = mapped_column(UtcDateTime)
    """Changes every few seconds while a process works on the job; PostgreSQL only."""
    error: Mapped[str | None] = mapped_column(Text)
    order: Mapped[int] = mapped_column(BigInteger, default=0, index=True)
    """Place in the queue: a counter, because clocks may differ."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
    started: Mapped[datetime | None] = mapped_column(UtcDateTime)
    finished: Mapped[datetime | None] = mapped_column(UtcDateTime)


class Event(Base):
    """A numbered event for pages; a page that reconnects continues after the last number that it has seen."""

    __tablename__ = "events"

    seq: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    kind: Mapped[str] = mapped_column(String(32))
    """``video``, ``run``, ``edit``, ``output``, ``model``, ``labels``, ``removed`` ..."""
    subject: Mapped[str] = mapped_column(String(64))
    data: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    time: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class Server(Base):
    """A server with a separate data folder on a database that several share."""

    __tablename__ = "servers"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    """Random; stored in the data folder."""
    name: Mapped[str] = mapped_column(Text)
    """Machine and data folder, for people."""
    beats: Mapped[int] = mapped_column(BigInteger, default=0)
    """Counts up while it runs."""
