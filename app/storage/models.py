"""The tables of the review tool. The same models serve SQLite and PostgreSQL.

Times are UTC. A video is named by the SHA-256 of its bytes, a run and a job by 32 hexadecimal digits.
"""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import JSON, BigInteger, Float, ForeignKey, Integer, LargeBinary, String, Text, func, select
from sqlalchemy.engine.default import DefaultExecutionContext
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, here, now
from app.storage.edit_tables import Edit, Follow, FollowPiece, TrackDocument
from app.storage.job_tables import Event, Job, Server
from app.storage.label_tables import LabelPicture, LabelSetDefault, LabelSetVersion, LabelWord
from app.storage.moments import Moment
from app.storage.output_tables import ModelVersion, Output
from app.storage.people_tables import Assignment, Person, PersonSecret, SecondOpinion
from app.storage.search_tables import SearchAttribute, SearchRun, SearchTrack, VideoTag
from app.storage.work_tables import ReviewCount, Verdict, WorkDay
from tsr_engine.json_shapes import JsonObject

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
    "ReviewCount",
    "Run",
    "SearchAttribute",
    "SearchRun",
    "SearchTrack",
    "SecondOpinion",
    "Server",
    "TrackDocument",
    "Verdict",
    "Video",
    "VideoTag",
    "WorkDay",
]


def _next_order(context: DefaultExecutionContext) -> int:
    """One more than the newest run has."""
    return (context.connection.scalar(select(func.max(Run.order))) or 0) + 1


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
    place: Mapped[str | None] = mapped_column(String(32), default=here)
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
    parameters: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    """Parameters that differ from the preset: name -> value."""
    first: Mapped[int] = mapped_column(Integer, default=0)
    """First frame."""
    stop: Mapped[int | None]
    """Frame after the last; NULL: to the end."""
    folder: Mapped[str] = mapped_column(Text, default="")
    """The evidence, relative to the data folder."""
    place: Mapped[str | None] = mapped_column(String(32), default=here)
    engine_version: Mapped[str] = mapped_column(String(32), default="")
    models: Mapped[dict[str, str]] = mapped_column(JSON, default=dict)
    """Model -> SHA-256."""
    labels: Mapped[JsonObject | None] = mapped_column(JSON(none_as_null=True))
    """What the class numbers of its evidence mean: ``{"keys": [...]}``, keys of labels by number; ``{"set": KEY}``, ids
    of that set; NULL: the keys of ``gtsrb-43`` in order."""
    frames_done: Mapped[int] = mapped_column(Integer, default=0)
    frames_total: Mapped[int | None]
    rate: Mapped[float | None] = mapped_column(Float)
    """Frames a second of the engine."""
    tracks: Mapped[int | None]
    """Confirmed tracks."""
    summary: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    """Figures of the complete run; for a what-if also ``difference`` against its parent."""
    order: Mapped[int] = mapped_column(BigInteger, default=_next_order, server_default="0", index=True)
    """Which run is newer; counts, never a clock."""
    created: Mapped[datetime] = mapped_column(Moment, default=now)
    started: Mapped[datetime | None] = mapped_column(Moment)
    finished: Mapped[datetime | None] = mapped_column(Moment)


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
