"""Reads runs of a data folder as sources, with the current corrections."""

from __future__ import annotations

from fractions import Fraction

from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from app.edits.log_store import documents_of
from app.errors import Conflict, Invalid
from app.exchange.dataset import Source, VideoFacts, source_of, times_of
from app.exchange.rates import exact_rate
from app.files.shared import present
from app.labels.mapping import classes_in
from app.settings import Settings
from app.storage.models import Run, Video
from app.storage.of_run import newest_edit, require_run
from app.storage.places import require_here
from app.videos.opened import library_file
from app.videos.table import unpack
from tsr_engine.evidence.schema import RUN_FILE

__all__ = ["home_source", "require_source", "video_facts"]


def home_source(session: Session, settings: Settings, run_id: str) -> Source:
    """Read a run of a data folder with the current corrections, all from one state of the database.

    Args:
        session: reads.
        settings: with the data folder and the limits of its videos.
        run_id: the run.

    Raises:
        NotFound: no such run.
        Conflict: it is not complete, or has no results.
        Elsewhere: it lies on another server.
    """
    run = _finished(session, settings, run_id)
    folder = present(settings, run.place, run.folder)
    query = select(Video).where(Video.id == run.video_id).options(undefer(Video.frame_table))
    facts = video_facts(session.scalars(query).one(), settings)
    revision = newest_edit(session, run_id)
    about = {"id": run.id, "name": run.name, "kind": run.kind, "preset": run.preset}
    return source_of(folder, documents_of(session, run_id), facts, revision, about, classes_in(session, run))


def require_source(session: Session, settings: Settings, run_id: str, video_id: str) -> None:
    """Refuse a run that ``home_source`` refuses, and a run of another video.

    Raises:
        NotFound, Conflict, Elsewhere: as for ``home_source``.
        Invalid: the run belongs to another video.
    """
    if _finished(session, settings, run_id).video_id != video_id:
        raise Invalid("The run belongs to another video. Choose a run of this video.", field="run")


def _finished(session: Session, settings: Settings, run_id: str) -> Run:
    run = require_run(session, run_id)
    require_here(session, run.place, run.name)
    if run.state in ("queued", "running"):
        raise Conflict(
            f"{run.name} is still {run.state}. Wait until it is complete, or cancel it.", code="still_running"
        )
    if not (present(settings, run.place, run.folder) / RUN_FILE).is_file():
        raise Conflict(f"{run.name} has no results to export.", code="no_evidence")
    return run


def video_facts(video: Video, settings: Settings) -> VideoFacts:
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
    return VideoFacts(
        name=video.name,
        sha256=video.id,
        width=video.width,
        height=video.height,
        frames=len(table),
        rate=rate,
        times=times_of(table),
        constant_rate=constant,
        path=file if file.there else None,
        limits=settings.video_limits,
        table=table,
        pixel_ratio=Fraction(video.pixel_ratio).limit_denominator(10_000),
    )
