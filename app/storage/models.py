"""The tables of the review tool. The same models serve SQLite and PostgreSQL.

Times are UTC. A video is named by the SHA-256 of its bytes, a run and a job by 32 hexadecimal digits.
"""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, BigInteger, Float, ForeignKey, Index, Integer, LargeBinary, String, Text, func, select
from sqlalchemy.engine.default import DefaultExecutionContext
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, Sequence, now
from app.storage.label_tables import LabelPicture, LabelSetDefault, LabelSetVersion, LabelWord
from app.storage.moments import Moment
from app.storage.people_tables import Assignment, Person, PersonSecret, SecondOpinion
from app.storage.search_tables import SearchAttribute, SearchRun, SearchTrack, VideoTag

__all__ = [
    "Assignment",
    "Base",
    "Edit",
    "Event",
    "Follow",
    "FollowPiece",
    "GroundTruth",
    "Job",
    "LabelPicture",
    "LabelSetDefault",
    "LabelSetVersion",
    "LabelWord",
    "ModelVersion",
    "Output",
    "Person",
    "PersonSecret",
    "Run",
    "SearchAttribute",
    "SearchRun",
    "SearchTrack",
    "SecondOpinion",
    "Server",
    "TrackDocument",
    "Video",
    "VideoTag",
]


def _next_order(context: DefaultExecutionContext) -> int:
    """One more than the newest run has."""
    return (context.connection.scalar(select(func.max(Run.order))) or 0) + 1


def _here(context: DefaultExecutionContext) -> str | None:
    """The server that writes; see ``app.storage.database``."""
    found: str | None = context.connection.get_execution_options().get("tsr_here")
    return found


class Video(Base):
    """A video file, by its content."""

    __tablename__ = "videos"

    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    """SHA-256 of the file."""
    name: Mapped[str] = mapped_column(Text)
    path: Mapped[str] = mapped_column(Text)
    """Where it was seen last; absolute."""
    size: Mapped[int] = mapped_column(BigInteger)
    """Bytes."""
    state: Mapped[str] = mapped_column(String(16), default="importing")
    """``importing``, ``ready`` or ``failed``."""
    error: Mapped[str | None] = mapped_column(Text)
    owned: Mapped[bool] = mapped_column(default=False)
    """True: an upload that lies in the data folder and goes with the video."""
    sample: Mapped[bool] = mapped_column(default=False)
    """True: a drive that ships with the tool."""
    width: Mapped[int | None]
    height: Mapped[int | None]
    rotation: Mapped[int | None]
    pixel_ratio: Mapped[float] = mapped_column(Float, default=1.0, server_default="1")
    """Width of an upright pixel by its height; pictures are shown so, coordinates are those of the stored pixels."""
    codec: Mapped[str | None] = mapped_column(String(32))
    rate: Mapped[float | None] = mapped_column(Float)
    """Announced frames a second; for playing speed only."""
    frames: Mapped[int | None]
    """Frames that decode."""
    duration: Mapped[float | None] = mapped_column(Float)
    """Seconds."""
    warnings: Mapped[list[str]] = mapped_column(JSON, default=list)
    frame_table: Mapped[bytes | None] = mapped_column(LargeBinary, deferred=True)
    """The frame table as ``app.videos.table`` packs it."""
    stamp: Mapped[list[int] | None] = mapped_column(JSON(none_as_null=True))
    """How the file stood when its bytes were last compared: ``tsr_engine.io.opened_file.Stamp``."""
    place: Mapped[str | None] = mapped_column(String(32), default=_here)
    """Server that the file lies with; NULL: whoever uses the database. So in all tables."""
    label_set: Mapped[str | None] = mapped_column(String(64))
    """Key of the set whose ids its documents and ground truths hold; NULL: the library's default."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)


class Run(Base):
    """One pass of the engine over a video, one what-if on its evidence, or an imported one; immutable when complete."""

    __tablename__ = "runs"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    video_id: Mapped[str] = mapped_column(ForeignKey("videos.id", ondelete="CASCADE"), index=True)
    kind: Mapped[str] = mapped_column(String(16), default="engine")
    """``engine``, ``whatif`` or ``imported``."""
    name: Mapped[str] = mapped_column(Text, default="")
    parent_id: Mapped[str | None] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"))
    """The run whose evidence a what-if replays."""
    state: Mapped[str] = mapped_column(String(16), default="queued")
    """``queued``, ``running``, ``complete``, ``failed``, ``cancelled`` or ``interrupted``."""
    error: Mapped[str | None] = mapped_column(Text)
    preset: Mapped[str] = mapped_column(String(32), default="default")
    parameters: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """Parameters that differ from the preset: name -> value."""
    first: Mapped[int] = mapped_column(Integer, default=0)
    """First frame."""
    stop: Mapped[int | None]
    """Frame after the last; NULL: to the end."""
    folder: Mapped[str] = mapped_column(Text, default="")
    """The evidence, relative to the data folder."""
    place: Mapped[str | None] = mapped_column(String(32), default=_here)
    engine_version: Mapped[str] = mapped_column(String(32), default="")
    models: Mapped[dict[str, str]] = mapped_column(JSON, default=dict)
    """Model -> SHA-256."""
    labels: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    """What the class numbers of its evidence mean: ``{"keys": [...]}``, keys of labels by number; ``{"set": KEY}``, ids
    of that set; NULL: the keys of ``gtsrb-43`` in order."""
    frames_done: Mapped[int] = mapped_column(Integer, default=0)
    frames_total: Mapped[int | None]
    rate: Mapped[float | None] = mapped_column(Float)
    """Frames a second of the engine."""
    tracks: Mapped[int | None]
    """Confirmed tracks."""
    summary: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """Figures of the complete run; for a what-if also ``difference`` against its parent."""
    order: Mapped[int] = mapped_column(BigInteger, default=_next_order, server_default="0", index=True)
    """Which run is newer; counts, never a clock."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)
    started: Mapped[datetime | None] = mapped_column(Moment)
    finished: Mapped[datetime | None] = mapped_column(Moment)


class Job(Base):
    """Work for a worker process: the durable queue."""

    __tablename__ = "jobs"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    kind: Mapped[str] = mapped_column(String(32))
    """``import``, ``track``, ``whatif`` ..."""
    subject: Mapped[str] = mapped_column(String(64), index=True)
    """The video or run that it works on."""
    payload: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
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
    place: Mapped[str | None] = mapped_column(String(32), default=_here)
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
    data: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    time: Mapped[datetime] = mapped_column(Moment, default=now)


class Edit(Base):
    """One operation of a person on the tracks of a run: a row of the append-only log."""

    __tablename__ = "edits"
    __table_args__ = (
        Index("edits_of_run", "run_id", "seq"),
        Index("edits_of_author", "run_id", "author", "seq"),
        Index("edits_by_author", "author", "seq", "created"),  # holds all that hours of work are counted from
        Index("edits_by_kind", "kind", "created"),
    )

    seq: Mapped[int] = mapped_column(Sequence, primary_key=True, autoincrement=True)
    op_id: Mapped[str] = mapped_column(String(64), unique=True)
    """Chosen by the page; the same operation sent twice is one row."""
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"))
    author: Mapped[str] = mapped_column(Text)
    kind: Mapped[str] = mapped_column(String(32))
    """Name of the command, or ``undo`` / ``redo``."""
    command: Mapped[dict[str, Any]] = mapped_column(JSON)
    frame: Mapped[int | None]
    """The frame that the person looked at."""
    before: Mapped[dict[str, Any]] = mapped_column(JSON)
    """Documents of the touched tracks before: key -> document, None where there was none."""
    after: Mapped[dict[str, Any]] = mapped_column(JSON)
    """The same after."""
    reverts: Mapped[str | None] = mapped_column(String(64))
    """The operation that an ``undo`` or ``redo`` is about."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)


class TrackDocument(Base):
    """A track as people have left it: the newest document of each edited track."""

    __tablename__ = "track_documents"

    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True)
    key: Mapped[str] = mapped_column(String(64), primary_key=True)
    revision: Mapped[int] = mapped_column(Integer)
    document: Mapped[dict[str, Any]] = mapped_column(JSON)


class Follow(Base):
    """A sign that is being followed for a person; gone once its proposals are accepted, dropped or left."""

    __tablename__ = "follows"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    run_id: Mapped[str] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), index=True)
    author: Mapped[str] = mapped_column(Text)
    key: Mapped[str] = mapped_column(String(64))
    """The track that the proposals are for."""
    request: Mapped[dict[str, Any]] = mapped_column(JSON)
    """``anchors``, ``only``, ``first``, ``last``."""
    state: Mapped[str] = mapped_column(String(16), default="queued")
    """``queued``, ``running``, ``complete``, ``failed`` or ``cancelled``."""
    error: Mapped[str | None] = mapped_column(Text)
    endings: Mapped[list[dict[str, Any]]] = mapped_column(JSON, default=list)
    """Why it ended, by direction."""
    pieces: Mapped[int] = mapped_column(Integer, default=0)
    """How many pieces have been stored."""
    asked: Mapped[datetime] = mapped_column(Moment, default=now)
    """When a page asked for it last."""


class FollowPiece(Base):
    """Some proposals of a follow, in the order in which they came."""

    __tablename__ = "follow_pieces"

    follow_id: Mapped[str] = mapped_column(ForeignKey("follows.id", ondelete="CASCADE"), primary_key=True)
    number: Mapped[int] = mapped_column(Integer, primary_key=True)
    proposals: Mapped[list[list[Any]]] = mapped_column(JSON)
    """Rows of frame, x1, y1, x2, y2, confidence, source."""


class GroundTruth(Base):
    """Ground truth of a video, imported."""

    __tablename__ = "truths"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    video_id: Mapped[str] = mapped_column(ForeignKey("videos.id", ondelete="CASCADE"), index=True)
    name: Mapped[str] = mapped_column(Text)
    boxes: Mapped[bytes] = mapped_column(LargeBinary, deferred=True)
    """Rows of frame, track, x1, y1, x2, y2, class, visibility, ignore: little-endian float64, deflated."""
    count: Mapped[int] = mapped_column(Integer)
    created: Mapped[datetime] = mapped_column(Moment, default=now)


class Output(Base):
    """A file that was made from runs and can be downloaded: an export, a recording, a bug bundle, a 3-D page."""

    __tablename__ = "artefacts"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    kind: Mapped[str] = mapped_column(String(16), index=True)
    """``export``, ``recording``, ``bundle`` or ``scene``."""
    run_id: Mapped[str | None] = mapped_column(ForeignKey("runs.id", ondelete="SET NULL"), index=True)
    """The run, where there is exactly one."""
    name: Mapped[str] = mapped_column(Text)
    """File name offered for the download."""
    state: Mapped[str] = mapped_column(String(16), default="queued")
    """``queued``, ``running``, ``complete``, ``failed`` or ``cancelled``."""
    error: Mapped[str | None] = mapped_column(Text)
    options: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """What was asked for."""
    done: Mapped[int] = mapped_column(Integer, default=0)
    total: Mapped[int | None]
    path: Mapped[str] = mapped_column(Text, default="")
    """Relative to the data folder; empty until it is whole."""
    place: Mapped[str | None] = mapped_column(String(32), default=_here)
    size: Mapped[int | None] = mapped_column(BigInteger)
    """Bytes."""
    sha256: Mapped[str] = mapped_column(String(64), default="")
    summary: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """Counts, skipped items with reasons."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)
    finished: Mapped[datetime | None] = mapped_column(Moment)


class ModelVersion(Base):
    """A set of trained models; immutable when complete."""

    __tablename__ = "model_versions"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    name: Mapped[str] = mapped_column(Text)
    state: Mapped[str] = mapped_column(String(16), default="queued")
    """``queued``, ``running``, ``complete``, ``failed`` or ``cancelled``."""
    error: Mapped[str | None] = mapped_column(Text)
    parent_id: Mapped[str | None] = mapped_column(String(32))
    """The version that it started from; NULL: the one that ships with the package."""
    folder: Mapped[str] = mapped_column(Text, default="")
    """The models, relative to the data folder."""
    place: Mapped[str | None] = mapped_column(String(32), default=_here)
    lineage: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """Exports with their edit revisions and hashes, data folders, parts trained, seed, split."""
    figures: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    """Held-out figures of this version and of its parent on the same data."""
    models: Mapped[dict[str, str]] = mapped_column(JSON, default=dict)
    """Model -> SHA-256."""
    stage: Mapped[str] = mapped_column(Text, default="")
    """What is being done, in words."""
    done: Mapped[int] = mapped_column(Integer, default=0)
    total: Mapped[int | None]
    promoted: Mapped[int] = mapped_column(Integer, default=0)
    """Counts up with each promotion; new runs use the complete version with the highest one, above 0."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)
    finished: Mapped[datetime | None] = mapped_column(Moment)


class Server(Base):
    """A server with a data folder of its own on a database that several share."""

    __tablename__ = "servers"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    """Random, kept in the data folder."""
    name: Mapped[str] = mapped_column(Text)
    """Machine and data folder, for people."""
    beats: Mapped[int] = mapped_column(BigInteger, default=0)
    """Counts up while it runs."""
