"""Reads runs of a data folder as sources, with the current corrections."""

from __future__ import annotations

from fractions import Fraction

from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from app.edits.log_store import documents_of
from app.errors import Conflict, Invalid
from app.exchange.dataset import Source, VideoInfo, source_of, times_of
from app.exchange.frame_rates import exact_rate
from app.files.shared import ensure_local
from app.labels.mapping import classes_in
from app.settings import Settings
from app.storage.lookup import newest_edit, require_run
from app.storage.models import Run, Video
from app.storage.servers import require_local
from app.videos.checked_file import library_file
from app.videos.packed_table import unpack
from tsr_engine.evidence.schema import RUN_FILE


def run_source(session: Session, settings: Settings, run_id: str) -> Source:
    """Read a run of a data folder with the current corrections, all from one state of the database.

    Args:
        session: reads.
        settings: with the data folder and the limits of its videos.
        run_id: the run.

    Raises:
        NotFound: no such run.
        Conflict: it is not complete, or has no results.
        OnOtherServer: it lies on another server.
    """
    run = _require_finished(session, settings, run_id)
    folder = ensure_local(settings, run.place, run.folder)
    query = select(Video).where(Video.id == run.video_id).options(undefer(Video.frame_table))
    info = video_info(session.scalars(query).one(), settings)
    revision = newest_edit(session, run_id)
    origin = {"id": run.id, "name": run.name, "kind": run.kind, "preset": run.preset}
    return source_of(folder, documents_of(session, run_id), info, revision, origin, classes_in(session, run))


def require_exportable(session: Session, settings: Settings, run_id: str, video_id: str) -> None:
    """Refuse a run that ``run_source`` refuses, and a run of another video.

    Raises:
        NotFound, Conflict, OnOtherServer: as for ``run_source``.
        Invalid: the run belongs to another video.
    """
    if _require_finished(session, settings, run_id).video_id != video_id:
        raise Invalid("The run belongs to another video. Choose a run of this video.", field="run")


def _require_finished(session: Session, settings: Settings, run_id: str) -> Run:
    run = require_run(session, run_id)
    require_local(session, run.place, run.name)
    if run.state in ("queued", "running"):
        raise Conflict(
            f"{run.name} is still {run.state}. Wait until it is complete, or cancel it.", code="still_running"
        )
    if not (ensure_local(settings, run.place, run.folder) / RUN_FILE).is_file():
        raise Conflict(f"{run.name} has no results to export.", code="no_evidence")
    return run


def video_info(video: Video, settings: Settings) -> VideoInfo:
    """Read a video of a data folder.

    Args:
        video: its frame table must be loaded.
        settings: with the limits of videos.

    Raises:
        Conflict: it is not imported yet.
    """
    if video.frame_table is None or video.width is None or video.height is None:
        raise Conflict(f"{video.name} is {video.state}: its frames are not known yet.", code="not_ready")
    table = unpack(video.frame_table)
    rate, constant = exact_rate(table.pts, table.time_base, video.rate)
    file = library_file(settings, video)
    return VideoInfo(
        name=video.name,
        sha256=video.id,
        width=video.width,
        height=video.height,
        frames=len(table),
        rate=rate,
        times=times_of(table),
        constant_rate=constant,
        path=file if file.exists else None,
        limits=settings.video_limits,
        table=table,
        pixel_ratio=Fraction(video.pixel_ratio).limit_denominator(10_000),
    )
