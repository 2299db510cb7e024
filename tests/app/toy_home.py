"""A data folder with one tracked toy video, for tests that read evidence."""

from __future__ import annotations

import shutil
import uuid
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from app.events import EventBus
from app.evidence.pixels import RunPixels
from app.evidence.service import EvidenceService
from app.job_kinds import KINDS
from app.jobs.queue import JobQueue
from app.settings import Settings
from app.storage.database import Database, sqlite_file
from app.storage.models import Run, Video
from app.videos.packed_table import pack
from tests import toy_pipeline
from tests.app.databases import put_tables
from tsr_engine.evidence import EvidenceReader
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video import open_video
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.runs.track_video import RunRequest, track_video


@dataclass
class ToyHome:
    """The folder, and services for tests of evidence."""

    settings: Settings
    database: Database
    events: EventBus
    jobs: JobQueue
    evidence: EvidenceService
    video_id: str
    run_id: str
    video: Path

    @cached_property
    def pixels(self) -> RunPixels:
        """Stored pixels around its boxes."""
        return RunPixels(self.settings, self.database, self.evidence)

    @property
    def folder(self) -> Path:
        return self.settings.home / "runs" / self.run_id

    def reader(self) -> EvidenceReader:
        return EvidenceReader(self.folder)

    def add_run(self, **values: Any) -> str:
        """Add a row to the table ``runs``."""
        run_id = uuid.uuid4().hex
        given: dict[str, Any] = {
            "id": run_id,
            "video_id": self.video_id,
            "kind": "engine",
            "name": "Other",
            "state": "complete",
        }
        given |= {"folder": f"runs/{run_id}", "preset": "default", "parameters": {"tau": 3.0}, "summary": {}}
        with self.database.write() as session:
            session.add(Run(**(given | values)))
        return run_id


class TrackedDrive(NamedTuple):
    """A toy drive and its run."""

    folder: TemporaryDirectory[str]
    digest: str
    table: FrameTable
    tracks: int


@cache
def _tracked(frames: int) -> TrackedDrive:
    """Track the toy drive once per process; all data folders get a copy."""
    folder = TemporaryDirectory(prefix="tsr-toy-")
    video = toy_pipeline.write_drive(Path(folder.name) / "drive.mp4", frames)
    with open_video(video) as file:
        table = file.confirm()
    request = RunRequest(video, toy_pipeline.PARAMS, Path(folder.name) / "run")
    report = track_video(request, toy_pipeline.components())
    return TrackedDrive(folder, video_sha256(video), table, len(report.tracks))


def make_home(folder: Path, frames: int = 75) -> ToyHome:
    """A data folder with the toy drive and a run over it."""
    settings = Settings(home=folder / "home", roots=(folder,), sample=False, token="t" * 24)
    settings.home.mkdir(parents=True)
    tracked, digest, table, tracks = _tracked(frames)
    video, run_id = folder / "drive.mp4", uuid.uuid4().hex
    shutil.copyfile(Path(tracked.name) / video.name, video)
    shutil.copytree(Path(tracked.name) / "run", settings.home / "runs" / run_id)
    if (database_file := sqlite_file(settings.database)) is not None:
        put_tables(database_file)
    database = Database(settings.database)
    events = EventBus()
    with database.write() as session:
        row = Video(id=digest, name="drive.mp4", path=str(video), size=video.stat().st_size, state="ready")
        row.width, row.height, row.frames, row.frame_table = (
            toy_pipeline.WIDTH,
            toy_pipeline.HEIGHT,
            len(table),
            pack(table),
        )
        row.warnings = []
        session.add(row)
    home = ToyHome(
        settings, database, events, JobQueue(events, KINDS), EvidenceService(settings, database), digest, run_id, video
    )
    home.add_run(id=run_id, folder=f"runs/{run_id}", name="Run 1", frames_done=frames, tracks=tracks)
    return home
