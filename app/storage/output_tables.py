"""Tables of outputs and of versions of the models; part of ``app.storage.models``."""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import JSON, BigInteger, ForeignKey, Integer, String, Text
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, current_server, now
from app.storage.utc_times import UtcDateTime
from tsr_engine.json_shapes import JsonObject


class Output(Base):
    """A file that was made from runs and can be downloaded: an export, a recording, a bug bundle, a 3-D page."""

    __tablename__ = "artefacts"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    kind: Mapped[str] = mapped_column(String(16), index=True)
    """``export``, ``recording``, ``bundle`` or ``scene``."""
    run_id: Mapped[str | None] = mapped_column(ForeignKey("runs.id", ondelete="SET NULL"), index=True)
    """Its run, if it is made from exactly one."""
    name: Mapped[str] = mapped_column(Text)
    """File name offered for the download."""
    state: Mapped[str] = mapped_column(String(16), default="queued")
    """``queued``, ``running``, ``complete``, ``failed`` or ``cancelled``."""
    error: Mapped[str | None] = mapped_column(Text)
    options: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    """Options of the request."""
    done: Mapped[int] = mapped_column(Integer, default=0)
    total: Mapped[int | None]
    path: Mapped[str] = mapped_column(Text, default="")
    """Path relative to the data folder; empty until it is complete."""
    place: Mapped[str | None] = mapped_column(String(32), default=current_server)
    size: Mapped[int | None] = mapped_column(BigInteger)
    """Bytes."""
    sha256: Mapped[str] = mapped_column(String(64), default="")
    summary: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    """Counts, skipped items with reasons."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
    finished: Mapped[datetime | None] = mapped_column(UtcDateTime)


class ModelVersion(Base):
    """A set of trained models; immutable when complete."""

    __tablename__ = "model_versions"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    name: Mapped[str] = mapped_column(Text)
    state: Mapped[str] = mapped_column(String(16), default="queued")
    """``queued``, ``running``, ``complete``, ``failed`` or ``cancelled``."""
    error: Mapped[str | None] = mapped_column(Text)
    parent_id: Mapped[str | None] = mapped_column(String(32))
    """Version that training started from; NULL: the shipped one."""
    folder: Mapped[str] = mapped_column(Text, default="")
    """Folder of the models, relative to the data folder."""
    place: Mapped[str | None] = mapped_column(String(32), default=current_server)
    lineage: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    """Exports with their edit revisions and hashes, data folders, parts trained, seed, split."""
    figures: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    """Held-out figures of this version and of its parent on the same data."""
    models: Mapped[dict[str, str]] = mapped_column(JSON, default=dict)
    """Model -> SHA-256."""
    stage: Mapped[str] = mapped_column(Text, default="")
    """Current step, in words."""
    note: Mapped[str] = mapped_column(Text, default="", server_default="")
    """What a worker does for its job besides its progress, in a few words; empty: nothing to say."""
    done: Mapped[int] = mapped_column(Integer, default=0)
    total: Mapped[int | None]
    promoted: Mapped[int] = mapped_column(Integer, default=0)
    """Number of its promotion, counting up; new runs use the complete version with the highest one above 0."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
    finished: Mapped[datetime | None] = mapped_column(UtcDateTime)
