"""Imports of annotations on the server: read in one sandbox, stored by another process that can be killed.

The reading process has no network and writes in one folder only. The storing process needs the database; it receives
arrays, checks them again, and never sees a byte of the file. If there are few tracks, the server stores them itself.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Final

import numpy as np

from app.edits.bulk import BulkEdits
from app.edits.log_store import LogStore
from app.errors import Busy, TooLarge
from app.events import EventBus
from app.evidence.service import EvidenceService
from app.exchange.as_ground_truth import ground_truth_rows
from app.exchange.dataset import VideoInfo
from app.exchange.import_file import ImportFile, VideoTarget, read_import_file, reader_target
from app.exchange.imports import ImportKind, ImportResult, ImportService
from app.exchange.running_imports import RunningImport
from app.ground_truths.service import GroundTruthService
from app.sandbox.channel import Channel
from app.sandbox.limits import NICE, Limits, writable_folders
from app.sandbox.sandboxes import SandboxError, Sandboxes, SandboxesClosed
from app.settings import Settings
from app.storage.database import Database, sqlite_file
from app.storage.identity import open_database
from app.storage.models import Base, Video
from tsr_engine.exchange.dataset_npz import read_dataset_npz, write_dataset_npz
from tsr_engine.exchange.formats import ImportLimits
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.json_shapes import JsonObject

_PACKED: Final = "tracks.npz"
_MAX_BYTES_IN_SERVER: Final = 1 << 18
"""Size of arrays (some thousand boxes) up to which the server stores them itself: starting a process takes longer."""
MAX_FRAMES_IN_SERVER: Final = 5000
"""Length of a video, frames, up to which the server writes a run itself."""


class SandboxedImports:
    """Imports files without reading their bytes in the server."""

    def __init__(self, settings: Settings, imports: ImportService, sandboxes: Sandboxes) -> None:
        self._settings = settings
        self._imports = imports
        self._sandboxes = sandboxes

    def import_file(
        self,
        video_id: str,
        file: ImportFile,
        kind: ImportKind,
        run_id: str | None,
        stop: Callable[[], bool],
        running_import: RunningImport | None = None,
    ) -> ImportResult:
        """Import a file; see ``ImportService.import_file``.

        Args:
            video_id: the video.
            file: the file; ``scratch`` is a folder for it alone.
            kind: import as this kind.
            run_id: the run that an annotation corrects.
            stop: returns whether the client has disconnected.
            running_import: its recorded progress, which also says whether it was cancelled.

        Raises:
            Busy: the import was stopped, or the server ends.
            TooLarge: it takes more memory or time than allowed.
            ApiError, TsrError: as for ``ImportService.import_file``.
        """
        assert file.scratch is not None
        running_import = running_import or RunningImport()
        target = self._imports.check(video_id, kind, run_id)
        packed = file.scratch / _PACKED
        limits = Limits(
            self._settings.import_memory_mb,
            computing=self._settings.import_seconds,
            wall=4.0 * self._settings.import_seconds,
            writable=(file.scratch,),
            nice=NICE,
        )

        def is_stopped() -> bool:
            return running_import.cancelled.is_set() or stop()

        def record_progress(message: JsonObject) -> None:
            running_import.boxes = int(message.get("boxes", 0))

        try:
            running_import.step = "reading"
            function = "app.exchange.sandboxed_imports:read_in_sandbox"
            self._sandboxes.run(
                function, file, target, packed, limits=limits, stop=is_stopped, on_message=record_progress
            )
            if is_stopped():
                raise SandboxesClosed("the client has disconnected, or the server ends")
            running_import.step = "storing"  # no cancelling from here on: it may already be stored
            if packed.stat().st_size <= _MAX_BYTES_IN_SERVER and (
                kind != "run" or target.video.frames <= MAX_FRAMES_IN_SERVER
            ):
                dataset = read_dataset_npz(packed, reader_target(file, target), file.path.name)
                return self._imports.store(video_id, target, file, kind, run_id, dataset)
            result = self._sandboxes.run(
                "app.exchange.sandboxed_imports:store_in_sandbox",
                *(self._settings, video_id, target, file, kind, run_id, packed),
                limits=self._storing_limits(limits),
                stop=stop,
            )
        except SandboxesClosed as error:
            if running_import.cancelled.is_set() and running_import.step != "storing":
                raise Busy("The import was cancelled. Nothing was imported.", code="cancelled") from None
            hint = "Nothing was imported."
            if running_import.step == "storing":
                hint = "It may have been stored: check before you send it again."
            raise Busy(f"The import was ended: {error}. {hint}") from None
        except SandboxError as error:
            raise TooLarge(
                f"{file.path.name} was not imported: {error}. Split the file, or give imports more with "
                "TSR_IMPORT_MEMORY_MB or TSR_IMPORT_SECONDS.",
                field="body",
                code="bad_file",
            ) from None
        return ImportResult.model_validate(result)

    def _storing_limits(self, limits: Limits) -> Limits:
        """Limits of the process that stores; it runs at normal priority, because others wait for the database."""
        database = sqlite_file(self._settings.database)
        if database is None:
            return replace(limits, nice=0, network=True)
        return replace(limits, nice=0, writable=writable_folders(self._settings.home, database))

    def create_empty_run(self, video_id: str, name: str, author: str) -> ImportResult:
        """Make a run without tracks, in another process for a long video; see ``ImportService.create_empty_run``.

        Raises:
            Busy: the other process failed, or the server ends.
        """
        target = self._imports.check(video_id, "run", None)
        if target.video.frames <= MAX_FRAMES_IN_SERVER:
            return self._imports.create_empty_run(video_id, name, author, target)
        limits = Limits(self._settings.import_memory_mb, computing=self._settings.import_seconds)
        try:
            function = "app.exchange.sandboxed_imports:create_run_in_sandbox"
            result = self._sandboxes.run(
                function, self._settings, video_id, name, author, target, limits=self._storing_limits(limits)
            )
        except SandboxError as error:
            raise Busy(f"The run was not created: {error}. Try again.") from None
        return ImportResult.model_validate(result)


def read_in_sandbox(channel: Channel, file: ImportFile, target: VideoTarget, packed: Path) -> int:
    """Run in the first sandbox: read the file to arrays."""
    return write_dataset_npz(packed, read_import_file(file, target, lambda boxes: channel.send({"boxes": boxes})))


def store_in_sandbox(
    _: Channel,
    settings: Settings,
    video_id: str,
    target: VideoTarget,
    file: ImportFile,
    kind: ImportKind,
    run_id: str | None,
    packed: Path,
) -> JsonObject:
    """Run in the second sandbox: store the arrays in the database and the data folder."""
    dataset = read_dataset_npz(packed, reader_target(file, target), file.path.name)
    packed.unlink()
    with _imports_of(settings) as imports:
        return imports.store(video_id, target, file, kind, run_id, dataset).model_dump(mode="json")


def create_run_in_sandbox(
    _: Channel, settings: Settings, video_id: str, name: str, author: str, target: VideoTarget
) -> JsonObject:
    """Run in a sandbox: make a run without tracks."""
    with _imports_of(settings) as imports:
        return imports.create_empty_run(video_id, name, author, target).model_dump(mode="json")


@contextmanager
def _imports_of(settings: Settings) -> Iterator[ImportService]:
    """The service in a separate process."""
    database = open_database(settings)
    events = EventBus()
    evidence = EvidenceService(settings, database)
    try:
        edits = BulkEdits(LogStore(database, events, evidence, settings))
        yield ImportService(settings, database, events, edits, GroundTruthService(database))
    finally:
        evidence.close()
        database.close()


def warm_up() -> None:
    """Import once, so that every sandbox that is forked later inherits what the first import sets up."""
    with tempfile.TemporaryDirectory(prefix="tsr-rehearsal-") as name:
        folder = Path(name)
        path, packed = folder / "a.csv", folder / _PACKED
        path.write_text("frame,track_id,x1,y1,x2,y2,class_id\n0,1,1,1,9,9,14\n", encoding="ascii")
        video = VideoInfo("a.mp4", "0" * 64, 16, 16, 1, None, None, True, None)
        ticks, false = np.zeros(1, np.int64), np.zeros(1, np.bool_)
        target = VideoTarget(
            video, FrameTable(Fraction(1, 25), ticks, ticks, ~false, false, 1, True), 0, ImportLimits()
        )
        file = ImportFile(path, "a", scratch=folder)
        write_dataset_npz(packed, read_import_file(file, target))
        tracks = read_dataset_npz(packed, reader_target(file, target), path.name).videos[0].tracks()
        database = Database(f"sqlite:///{folder / 'a.sqlite'}")
        Base.metadata.create_all(database.engine)
        with database.write() as session:
            session.add(Video(id="0" * 64, name="a.mp4", path="a.mp4", size=0, state="ready", warnings=[]))
        GroundTruthService(database).put_rows("0" * 64, "a", ground_truth_rows(tracks))
        database.close()
