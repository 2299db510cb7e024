"""Answers the routes about a run's evidence."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TypeVar

import numpy as np
from sqlalchemy import select

from app.body_model import Model
from app.errors import ApiError, Busy, Conflict, Invalid, NotFound
from app.evidence.answer_cache import AnswerCache
from app.evidence.disagreement import DisagreementFinder
from app.evidence.gate_flips import Flips, flips
from app.evidence.lane import TrackLane, track_lane
from app.evidence.overlays import MAX_FRAMES, Overlay, overlays
from app.evidence.reader_pool import ReaderPool
from app.evidence.run_columns import confirmed_boxes, labelled_boxes
from app.evidence.source_lanes import LaneColumns, lane_columns
from app.evidence.stored_run import StoredRun
from app.evidence.tracks import (
    TrackColumns,
    TrackProperties,
    label_tracks,
    no_tracks,
    read_track_properties,
    track_columns,
)
from app.files.shared import ensure_local
from app.labels.mapping import classes_in
from app.settings import Settings
from app.storage.database import Database
from app.storage.lookup import require_run
from app.storage.models import Run
from app.storage.servers import is_local, require_local
from tsr_engine.errors import StorageError, TsrError
from tsr_engine.evidence.columns import read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.track_table import TrackTable

Box = tuple[float, float, float, float]
_T = TypeVar("_T")


class EvidenceService:
    """Reads evidence for the page; thread-safe."""

    def __init__(self, settings: Settings, database: Database) -> None:
        self._settings = settings
        self._home = settings.home
        self._database = database
        self._pool = ReaderPool()
        self._disagreements = DisagreementFinder(database, self.boxes)
        self._lock = threading.Lock()
        self._answer_cache = AnswerCache()
        self._track_properties: OrderedDict[str, TrackProperties] = OrderedDict()

    def close(self) -> None:
        """Close all stores."""
        self._pool.close()

    def forget(self, run_id: str) -> None:
        """Drop the data of a run that was removed."""
        self._answer_cache.forget(run_id)
        with self._lock:
            self._track_properties.pop(run_id, None)
        self._disagreements.forget(run_id)
        self._pool.forget(self._home / "runs" / run_id)

    def has_local_files(self, run_id: str) -> bool:
        """Whether the evidence of a run lies in the data folder, so that it need not be fetched."""
        return (self._home / "runs" / run_id).is_dir()

    def stored_run(self, run_id: str) -> StoredRun:
        """Find the evidence of a run.

        Raises:
            NotFound: no such run.
            OnOtherServer: it lies on another server.
            Busy: it is still being fetched from the shared files.
        """
        with self._database.read() as session:
            row = require_run(session, run_id)
            require_local(session, row.place, row.name)
            classes = classes_in(session, row)
            state = row.state, row.parent_id, row.preset, dict(row.parameters)
        folder = ensure_local(self._settings, row.place, row.folder)
        return StoredRun(row.id, row.video_id, folder, *state, classes)

    @contextmanager
    def reading(self, run: StoredRun) -> Iterator[EvidenceReader]:
        """Yield a reader of the run.

        Raises:
            Conflict: the run has no results yet, or its evidence is missing.
        """
        if not run.has_results:
            raise Conflict("The run has no results yet. Wait for its first frames.", code="no_evidence")
        with self._pool.reading(run.folder) as reader:
            yield reader

    # ------------------------------------------------------------------------------------------- about whole runs

    def warm(self) -> None:
        """Compute the page's first answers for the newest complete run, so that it opens at once."""
        with self._database.read() as session:
            is_available = Run.state == "complete", is_local(session, Run.place)
            query = select(Run.id).where(*is_available).order_by(Run.order.desc()).limit(1)
            newest = session.scalars(query).first()
        if newest is not None:
            with suppress(ApiError, TsrError):  # reported when somebody opens the run
                self.lanes(newest)
                self.tracks(newest)

    def tracks(self, run_id: str) -> bytes:
        """``TrackColumns`` as JSON; empty columns if the run has no results yet."""
        run = self.stored_run(run_id)
        if not run.readable():
            return _json(no_tracks(run.tau))
        others = self._disagreements.version(run.id, run.video_id)
        labels = run.classes.labels
        state = ("tracks", run.id, *others, labels.key, str(labels.version))
        try:
            return self._cached(state, run, lambda: self._tracks(run))
        except (Busy, StorageError):
            # the other run cannot be fetched now; the answer is not cached, so the next request compares with it
            return _json(self._tracks(run, compare=False))

    def uncertainties(self, run_id: str) -> dict[int, float]:
        """Uncertainty of each track by number; an imported run has none. No other run is read, as none changes it."""
        columns = self._tracks(self.stored_run(run_id), compare=False)
        listed = zip(columns.id, columns.uncertainty, strict=True)
        return {number: value for number, value in listed if value is not None}

    def lanes(self, run_id: str) -> bytes:
        """``LaneColumns`` as JSON."""
        run = self.stored_run(run_id)
        if not run.readable():
            return _json(LaneColumns(track=[], first=[], last=[], source=[]))
        return self._cached(("lanes", run.id), run, lambda: self._query(run, lane_columns))

    def flips(self, run_id: str, tau: float) -> Flips:
        """Verdicts that another tau would change."""
        run = self.stored_run(run_id)
        with self.reading(run) as reader:
            return flips(reader, tau)

    def boxes(self, run_id: str, unmapped: Callable[[str], int] | None = None) -> TrackTable:
        """All boxes of the run's confirmed tracks, with labels of the video's set.

        Args:
            run_id: the run.
            unmapped: maps the model's name of a class without a label in the set to a label number; unset: no label.
        """
        run = self.stored_run(run_id)
        with self.reading(run) as reader:
            return labelled_boxes(confirmed_boxes(reader), run.classes, unmapped)

    def stored_frames(self, run_id: str) -> tuple[int, int] | None:
        """First and last stored frame of the run; None: there is none."""
        run = self.stored_run(run_id)
        with self.reading(run) as reader:
            first, last = reader.first_frame, reader.last_frame
        return None if first is None or last is None else (first, last)

    def span(self, run_id: str, track_id: int) -> tuple[int, int] | None:
        """First and last frame in which a confirmed track is not dead; None: the run has no such track."""
        return self._spans(run_id, (track_id, track_id)).get(track_id)

    def all_spans(self, run_id: str) -> dict[int, tuple[int, int]]:
        """First and last frame of each confirmed track, by number."""
        return self._spans(run_id, None)

    def _spans(self, run_id: str, tracks: tuple[int, int] | None) -> dict[int, tuple[int, int]]:
        names = ("track_id", "first_frame", "last_frame")
        with self.reading(self.stored_run(run_id)) as reader:
            rows = read_columns(reader, "tracks", *names, tracks=tracks, confirmed=True)
        return {track: (a, b) for track, a, b in zip(*(rows.ints(name).tolist() for name in names), strict=True)}

    def gaps(self, run_id: str, track_id: int) -> list[tuple[int, int | None]]:
        """First and last frames of the gaps in which a confirmed track has no box after its first one.

        The gap after the end of a track has no last frame. A track that has a box in the newest frame has not ended.
        """
        with self.reading(self.stored_run(run_id)) as reader:
            rows = read_columns(
                reader, "track_frames", "frame", tracks=(track_id, track_id), alive=True, confirmed=True
            )
            frames, newest = rows.ints("frame"), reader.last_frame
        if not len(frames) or newest is None:
            return []
        before = np.flatnonzero(np.diff(frames) > 1)
        firsts, lasts = frames[before] + 1, frames[before + 1] - 1
        end = int(frames[-1])
        return [*zip(firsts.tolist(), lasts.tolist(), strict=True), *([(end + 1, None)] if end < newest else [])]

    def label(self, run_id: str, track_id: int) -> int | None:
        """The engine's label of a confirmed track, in the video's set; -1: the set lacks the engine's class.

        Returns:
            None: the track was never classified, or does not exist.
        """
        run = self.stored_run(run_id)
        with self.reading(run) as reader:
            rows = read_columns(reader, "tracks", "class_id", tracks=(track_id, track_id), confirmed=True)
        class_number = next((number for number in rows.ints("class_id").tolist() if number >= 0), None)
        return None if class_number is None else run.classes.to_label(class_number)

    # ------------------------------------------------------------------------------------- about frames and tracks

    def overlays(self, run_id: str, first: int, last: int) -> list[Overlay]:
        """Overlays of a window of frames.

        Raises:
            Invalid: the window is empty or too long.
        """
        if not first <= last < first + MAX_FRAMES:
            raise Invalid(f"Request 1 to {MAX_FRAMES} frames. Got {first} to {last}.", field="last")
        run = self.stored_run(run_id)
        if not run.readable():
            return []
        with self.reading(run) as reader:
            return overlays(reader, first, last, run.classes)

    def track(self, run_id: str, track_id: int) -> TrackLane:
        """One track frame by frame.

        Raises:
            NotFound: the run has no such track.
        """
        run = self.stored_run(run_id)
        with self.reading(run) as reader:
            lane = track_lane(reader, track_id, run.classes)
        if lane is None:
            raise NotFound(f"The run has no track {track_id}.")
        return lane

    # ------------------------------------------------------------------------------------------------------ inside

    def _tracks(self, run: StoredRun, *, compare: bool = True) -> TrackColumns:
        properties = self._track_properties.get(run.id) if run.complete else None
        if properties is None:
            properties = self._query(run, read_track_properties)
            if run.complete:
                with self._lock:
                    self._track_properties[run.id] = properties
                    while len(self._track_properties) > 4:
                        self._track_properties.popitem(last=False)
        properties, names = label_tracks(properties, run.classes)
        labels = run.classes.labels
        disagreement = (
            self._disagreements.disagreement(run.id, run.video_id, properties, labels)
            if compare and run.complete
            else None
        )
        overruled = self._disagreements.overruled(run.id, properties, labels)
        return track_columns(properties, names, disagreement, overruled, run.complete)

    def _query(self, run: StoredRun, query: Callable[[EvidenceReader], _T]) -> _T:
        with self.reading(run) as reader:
            return query(reader)

    def _cached(self, key: tuple[str, ...], run: StoredRun, make: Callable[[], Model]) -> bytes:
        """Cache an answer: of a complete run for good, of a growing run for each chunk."""
        if not run.complete:
            with self.reading(run) as reader:
                key = (*key, str(reader.last_frame))
        return self._answer_cache.get(key, lambda: _json(make()))


def _json(answer: Model) -> bytes:
    return answer.__pydantic_serializer__.to_json(answer)
