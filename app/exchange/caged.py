"""Imports of annotations on the server: read in one cage, stored by another process that can be killed.

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

from app.cages.cage import CageError, Cages, CagesClosed
from app.cages.limits import NICE, Limits, stored_in
from app.cages.talk import Talk
from app.edits.bulk import BulkEdits
from app.edits.log_store import LogStore
from app.errors import Busy, TooLarge
from app.events import EventBus
from app.evidence.service import EvidenceService
from app.exchange.as_truth import truth_rows
from app.exchange.dataset import VideoFacts
from app.exchange.imports import ImportKind, ImportResult, ImportService
from app.exchange.incoming import Incoming, Onto, read_incoming, target_of
from app.exchange.underway import Import
from app.ground_truths.service import GroundTruthService
from app.settings import Settings
from app.storage.database import Database, sqlite_file
from app.storage.identity import database_of
from app.storage.models import Base, Video
from tsr_engine.exchange.dataset_npz import read_dataset_npz, write_dataset_npz
from tsr_engine.exchange.formats import ImportLimits
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.json_shapes import JsonObject

__all__ = ["SHORT", "CagedImports", "read_apart", "rehearse", "store_apart"]

_PACKED: Final = "tracks.npz"
_SMALL: Final = 1 << 18
"""Size of arrays (some thousand boxes) up to which the server stores them itself: starting a process takes longer."""
SHORT: Final = 5000
"""Length of a video, frames, up to which the server writes a run itself."""


class CagedImports:
    """Imports files without reading their bytes in the server."""

    def __init__(self, settings: Settings, imports: ImportService, cages: Cages) -> None:
        self._settings = settings
        self._imports = imports
        self._cages = cages

    def bring_in(
        self,
        video_id: str,
        incoming: Incoming,
        kind: ImportKind,
        run_id: str | None,
        stop: Callable[[], bool],
        underway: Import | None = None,
    ) -> ImportResult:
        """Import a file; see ``ImportService.bring_in``.

        Args:
            video_id: the video.
            incoming: the file; ``scratch`` is a folder for it alone.
            kind: import as this kind.
            run_id: the run that an annotation corrects.
            stop: returns whether the client has disconnected.
            underway: its recorded progress, which also says whether it was cancelled.

        Raises:
            Busy: the import was stopped, or the server ends.
            TooLarge: it takes more memory or time than allowed.
            ApiError, TsrError: as for ``ImportService.bring_in``.
        """
        assert incoming.scratch is not None
        underway = underway or Import()
        onto = self._imports.check(video_id, kind, run_id)
        packed = incoming.scratch / _PACKED
        limits = Limits(
            self._settings.import_memory_mb,
            computing=self._settings.import_seconds,
            wall=4.0 * self._settings.import_seconds,
            writable=(incoming.scratch,),
            nice=NICE,
        )

        def ended() -> bool:
            return underway.cancelled.is_set() or stop()

        def note(said: JsonObject) -> None:
            underway.boxes = int(said.get("boxes", 0))

        try:
            underway.step = "reading"
            read = "app.exchange.caged:read_apart"
            self._cages.run(read, incoming, onto, packed, limits=limits, stop=ended, on_message=note)
            if ended():
                raise CagesClosed("the client has disconnected, or the server ends")
            underway.step = "storing"  # no cancelling from here on: it may already be stored
            if packed.stat().st_size <= _SMALL and (kind != "run" or onto.facts.frames <= SHORT):
                dataset = read_dataset_npz(packed, target_of(incoming, onto), incoming.path.name)
                return self._imports.store(video_id, onto, incoming, kind, run_id, dataset)
            found = self._cages.run(
                "app.exchange.caged:store_apart",
                *(self._settings, video_id, onto, incoming, kind, run_id, packed),
                limits=self._storing(limits),
                stop=stop,
            )
        except CagesClosed as error:
            if underway.cancelled.is_set() and underway.step != "storing":
                raise Busy("The import was cancelled. Nothing was imported.", code="cancelled") from None
            stored = "It may have been stored: check before you send it again." if underway.step == "storing" else None
            raise Busy(f"The import was ended: {error}. {stored or 'Nothing was imported.'}") from None
        except CageError as error:
            raise TooLarge(
                f"{incoming.path.name} was not imported: {error}. Split the file, or give imports more with "
                "TSR_IMPORT_MEMORY_MB or TSR_IMPORT_SECONDS.",
                field="body",
                code="bad_file",
            ) from None
        return ImportResult.model_validate(found)

    def _storing(self, limits: Limits) -> Limits:
        """Limits of the process that stores; it runs at normal priority, because others wait for the database."""
        database = sqlite_file(self._settings.database)
        if database is None:
            return replace(limits, nice=0, network=True)
        return replace(limits, nice=0, writable=stored_in(self._settings.home, database))

    def begin_by_hand(self, video_id: str, name: str, author: str) -> ImportResult:
        """Make a run without tracks, in another process for a long video; see ``ImportService.begin_by_hand``.

        Raises:
            Busy: the other process failed, or the server ends.
        """
        onto = self._imports.check(video_id, "run", None)
        if onto.facts.frames <= SHORT:
            return self._imports.begin_by_hand(video_id, name, author, onto)
        limits = Limits(self._settings.import_memory_mb, computing=self._settings.import_seconds)
        try:
            found = self._cages.run(
                *("app.exchange.caged:begin_apart", self._settings, video_id, name, author, onto),
                limits=self._storing(limits),
            )
        except CageError as error:
            raise Busy(f"The run was not created: {error}. Try again.") from None
        return ImportResult.model_validate(found)


def read_apart(talk: Talk, incoming: Incoming, onto: Onto, packed: Path) -> int:
    """Run in the first cage: read the file to arrays."""
    return write_dataset_npz(packed, read_incoming(incoming, onto, lambda boxes: talk.send({"boxes": boxes})))


def store_apart(
    _: Talk,
    settings: Settings,
    video_id: str,
    onto: Onto,
    incoming: Incoming,
    kind: ImportKind,
    run_id: str | None,
    packed: Path,
) -> JsonObject:
    """Run in the second cage: store the arrays in the database and the data folder."""
    dataset = read_dataset_npz(packed, target_of(incoming, onto), incoming.path.name)
    packed.unlink()
    with _imports_of(settings) as imports:
        return imports.store(video_id, onto, incoming, kind, run_id, dataset).model_dump(mode="json")


def begin_apart(_: Talk, settings: Settings, video_id: str, name: str, author: str, onto: Onto) -> JsonObject:
    """Run in a cage: make a run without tracks."""
    with _imports_of(settings) as imports:
        return imports.begin_by_hand(video_id, name, author, onto).model_dump(mode="json")


@contextmanager
def _imports_of(settings: Settings) -> Iterator[ImportService]:
    """The service in a separate process."""
    database = database_of(settings)
    events = EventBus()
    evidence = EvidenceService(settings, database)
    try:
        edits = BulkEdits(LogStore(database, events, evidence, settings))
        yield ImportService(settings, database, events, edits, GroundTruthService(database))
    finally:
        evidence.close()
        database.close()


def rehearse() -> None:
    """Import once, so that every cage that is forked later inherits what the first import sets up."""
    with tempfile.TemporaryDirectory(prefix="tsr-rehearsal-") as name:
        folder = Path(name)
        file, packed = folder / "a.csv", folder / _PACKED
        file.write_text("frame,track_id,x1,y1,x2,y2,class_id\n0,1,1,1,9,9,14\n", encoding="ascii")
        facts = VideoFacts("a.mp4", "0" * 64, 16, 16, 1, None, None, True, None)
        ticks, no = np.zeros(1, np.int64), np.zeros(1, np.bool_)
        onto = Onto(facts, FrameTable(Fraction(1, 25), ticks, ticks, ~no, no, 1, True), 0, ImportLimits())
        incoming = Incoming(file, "a", scratch=folder)
        write_dataset_npz(packed, read_incoming(incoming, onto))
        tracks = read_dataset_npz(packed, target_of(incoming, onto), file.name).videos[0].tracks()
        database = Database(f"sqlite:///{folder / 'a.sqlite'}")
        Base.metadata.create_all(database.engine)
        with database.write() as session:
            session.add(Video(id="0" * 64, name="a.mp4", path="a.mp4", size=0, state="ready", warnings=[]))
        GroundTruthService(database).put_rows("0" * 64, "a", truth_rows(tracks))
        database.close()
