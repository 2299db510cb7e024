"""The tables of the review tool. The same models serve SQLite and PostgreSQL.

Times are UTC. The id of a video is the SHA-256 of its bytes, that of a run or a job 32 hexadecimal digits.
"""

from __future__ import annotations

from datetime import datetime

from sqlalchemy import JSON, BigInteger, Float, ForeignKey, Integer, LargeBinary, String, Text, func, select
from sqlalchemy.engine.default import DefaultExecutionContext
from sqlalchemy.orm import Mapped, mapped_column

from app.storage.base import Base, current_server, now
from app.storage.edit_tables import Edit, Follow, FollowPiece, TrackDocument
from app.storage.job_tables import Event, Job, Server
from app.storage.label_tables import LabelPicture, LabelSetDefault, LabelSetVersion, LabelWord
from app.storage.output_tables import ModelVersion, Output
from app.storage.people_tables import Assignment, Person, PersonSecret, SecondOpinion
from app.storage.search_tables import SearchAttribute, SearchRun, SearchTrack, VideoTag
from app.storage.utc_times import UtcDateTime
from app.storage.work_tables import ReviewCount, Verdict, WorkDay
from tsr_engine.json_shapes import JsonObject

__all__ = [
    "Assignment", "Base", "Edit", "Event", "Follow", "FollowPiece", "GroundTruth", "Job", "LabelPicture",
    "LabelSetDefault", "LabelSetVersion", "LabelWord", "ModelVersion", "Output", "Person", "PersonSecret",
    "ReviewCount", "Run", "SearchAttribute", "SearchRun", "SearchTrack", "SecondOpinion", "Server", "TrackDocument",
    "Verdict", "Video", "VideoTag", "WorkDay",
]  # fmt: skip


def _next_order(context: DefaultExecutionContext) -> int:
    """One more than the newest run's number."""
    return (context.connection.scalar(select(func.max(Run.order))) or 0) + 1


class Video(Base):
    """A video file, by its content."""

    __tablename__ = "videos"

    id: Mapped[str] = mapped_column(String(64), primary_key=True)
    """SHA-256 of the file."""
    name: Mapped[str] = mapped_column(Text)
    path: Mapped[str] = mapped_column(Text)
    """Last known path; absolute."""
    size: Mapped[int] = mapped_column(BigInteger)
    """Bytes."""
    state: Mapped[str] = mapped_column(String(16), default="importing")
    """``importing``, ``ready`` or ``failed``."""
    error: Mapped[str | None] = mapped_column(Text)
    owned: Mapped[bool] = mapped_column(default=False)
    """True: an upload in the data folder, which is deleted with the video."""
    sample: Mapped[bool] = mapped_column(default=False)
    """True: a drive that ships with the tool."""
    width: Mapped[int | None]
    height: Mapped[int | None]
    rotation: Mapped[int | None]
    pixel_ratio: Mapped[float] = mapped_column(Float, default=1.0, server_default="1")
    """Width of a pixel by its height, for display; coordinates are those of the stored pixels."""
    codec: Mapped[str | None] = mapped_column(String(32))
    rate: Mapped[float | None] = mapped_column(Float)
    """Frames per second in the header; used only for the playing speed."""
    frames: Mapped[int | None]
    """Number of frames that can be decoded."""
    duration: Mapped[float | None] = mapped_column(Float)
    """Seconds."""
    warnings: Mapped[list[str]] = mapped_column(JSON, default=list)
    frame_table: Mapped[bytes | None] = mapped_column(LargeBinary, deferred=True)
    """The frame table, packed by ``app.videos.packed_table``."""
    stamp: Mapped[list[int] | None] = mapped_column(JSON(none_as_null=True))
    """State of the file when its bytes were last compared: ``tsr_engine.io.opened_file.Stamp``."""
    place: Mapped[str | None] = mapped_column(String(32), default=current_server)
    """Server that has the file; NULL: the only server of the database. The same in all tables."""
    label_set: Mapped[str | None] = mapped_column(String(64))
    """Key of the label set of its documents and ground truths; NULL: the library's default."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)


class Run(Base):
    """One run of the engine over a video, a what-if on its evidence, or an imported run; immutable when complete."""

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
    place: Mapped[str | None] = mapped_column(String(32), default=current_server)
    engine_version: Mapped[str] = mapped_column(String(32), default="")
    models: Mapped[dict[str, str]] = mapped_column(JSON, default=dict)
    """Model -> SHA-256."""
    labels: Mapped[JsonObject | None] = mapped_column(JSON(none_as_null=True))
    """Meaning of the class numbers of its evidence. ``{"keys": [...]}``: keys of labels by number; ``{"set": KEY}``:
    ids of that set; NULL: the keys of ``gtsrb-43`` in order.
    """
    frames_done: Mapped[int] = mapped_column(Integer, default=0)
    frames_total: Mapped[int | None]
    rate: Mapped[float | None] = mapped_column(Float)
    """The engine's speed, frames per second."""
    note: Mapped[str] = mapped_column(Text, default="", server_default="")
    """What a worker does for its job besides its progress, in a few words; empty: nothing to say."""
    tracks: Mapped[int | None]
    """Confirmed tracks."""
    summary: Mapped[JsonObject] = mapped_column(JSON, default=dict)
    """Figures of the complete run; for a what-if also ``difference`` against its parent."""
    order: Mapped[int] = mapped_column(BigInteger, default=_next_order, server_default="0", index=True)
    """Number of the run: a counter, because clocks may be wrong."""
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
    started: Mapped[datetime | None] = mapped_column(UtcDateTime)
    finished: Mapped[datetime | None] = mapped_column(UtcDateTime)


class GroundTruth(Base):
    """Imported ground truth of a video."""

    __tablename__ = "truths"

    id: Mapped[str] = mapped_column(String(32), primary_key=True)
    video_id: Mapped[str] = mapped_column(ForeignKey("videos.id", ondelete="CASCADE"), index=True)
    name: Mapped[str] = mapped_column(Text)
    boxes: Mapped[bytes] = mapped_column(LargeBinary, deferred=True)
    """Rows of frame, track, x1, y1, x2, y2, class, visibility, ignore: little-endian float64, deflated."""
    count: Mapped[int] = mapped_column(Integer)
    created: Mapped[datetime] = mapped_column(UtcDateTime, default=now)
