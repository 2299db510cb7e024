"""Answers the routes about a run's evidence."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TypeVar

from sqlalchemy import select

from app.errors import ApiError, Conflict, Invalid, NotFound
from app.evidence.answers import Answers
from app.evidence.disagreement import Others
from app.evidence.flips import Flips, flips
from app.evidence.lane import TrackLane, track_lane
from app.evidence.lanes import LaneColumns, lane_columns
from app.evidence.overlays import MOST_FRAMES, Overlay, overlays
from app.evidence.place import RunPlace
from app.evidence.pool import ReaderPool
from app.evidence.tables import confirmed_boxes, labelled_boxes
from app.evidence.tracks import TrackFacts, labelled_facts, no_tracks, track_columns, track_facts
from app.files.shared import present
from app.labels.mapping import classes_in
from app.settings import Settings
from app.shapes import Model
from app.storage.database import Database
from app.storage.models import Run
from app.storage.of_run import require_run
from app.storage.places import is_here, require_here
from tsr_engine.errors import TsrError
from tsr_engine.evidence.columns import read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.track_table import TrackTable

__all__ = ["EvidenceService"]

Box = tuple[float, float, float, float]
_T = TypeVar("_T")


class EvidenceService:
    """Reads evidence for the page; thread-safe."""

    def __init__(self, settings: Settings, database: Database) -> None:
        self._settings = settings
        self._home = settings.home
        self._database = database
        self._pool = ReaderPool()
        self._others = Others(database, self.boxes)
        self._lock = threading.Lock()
        self._answers = Answers()
        self._facts: OrderedDict[str, TrackFacts] = OrderedDict()

    def close(self) -> None:
        """Close all stores."""
        self._pool.close()

    def forget(self, run_id: str) -> None:
        """Drop the data of a run that was removed."""
        self._answers.forget(run_id)
        with self._lock:
            self._facts.pop(run_id, None)
        self._others.forget(run_id)
        self._pool.forget(self._home / "runs" / run_id)

    def lies_here(self, run_id: str) -> bool:
        """Whether the evidence of a run lies in the data folder, so that it need not be fetched."""
        return (self._home / "runs" / run_id).is_dir()

    def place(self, run_id: str) -> RunPlace:
        """Find the evidence of a run.

        Raises:
            NotFound: no such run.
            Elsewhere: it lies on another server.
            Busy: it is still being fetched from the shared files.
        """
        with self._database.read() as session:
            run = require_run(session, run_id)
            require_here(session, run.place, run.name)
            classes = classes_in(session, run)
            about = run.state, run.parent_id, run.preset, dict(run.parameters)
        folder = present(self._settings, run.place, run.folder)
        return RunPlace(run.id, run.video_id, folder, *about, classes)

    @contextmanager
    def reading(self, place: RunPlace) -> Iterator[EvidenceReader]:
        """Yield a reader of the run.

        Raises:
            Conflict: the run has no results yet, or its evidence is missing.
        """
        if not place.begun:
            raise Conflict("The run has no results yet. Wait for its first frames.", code="no_evidence")
        with self._pool.reading(place.folder) as reader:
            yield reader

    # ------------------------------------------------------------------------------------------- about whole runs

    def warm(self) -> None:
        """Compute the page's first answers for the newest complete run, so that it opens at once."""
        with self._database.read() as session:
            ours = Run.state == "complete", is_here(session, Run.place)
            query = select(Run.id).where(*ours).order_by(Run.order.desc()).limit(1)
            newest = session.scalars(query).first()
        if newest is not None:
            with suppress(ApiError, TsrError):  # reported when somebody opens the run
                self.lanes(newest)
                self.tracks(newest)

    def tracks(self, run_id: str) -> bytes:
        """``TrackColumns`` as JSON; empty columns if the run has no results yet."""
        place = self.place(run_id)
        if not place.readable():
            return _json(no_tracks(place.tau))
        others = self._others.version(place.id, place.video_id)
        labels = place.classes.labels
        state = ("tracks", place.id, *others, labels.key, str(labels.version))
        return self._cached(state, place, lambda: self._tracks(place))

    def lanes(self, run_id: str) -> bytes:
        """``LaneColumns`` as JSON."""
        place = self.place(run_id)
        if not place.readable():
            return _json(LaneColumns(track=[], first=[], last=[], source=[]))
        return self._cached(("lanes", place.id), place, lambda: self._ask(place, lane_columns))

    def flips(self, run_id: str, tau: float) -> Flips:
        """Verdicts that another tau would change."""
        place = self.place(run_id)
        with self.reading(place) as reader:
            return flips(reader, tau)

    def boxes(self, run_id: str, unmapped: Callable[[str], int] | None = None) -> TrackTable:
        """All boxes of the run's confirmed tracks, with labels of the video's set.

        Args:
            run_id: the run.
            unmapped: maps the model's name of a class without a label in the set to a label number; unset: no label.
        """
        place = self.place(run_id)
        with self.reading(place) as reader:
            return labelled_boxes(confirmed_boxes(reader), place.classes, unmapped)

    def stored_frames(self, run_id: str) -> tuple[int, int] | None:
        """First and last stored frame of the run; None: there is none."""
        place = self.place(run_id)
        with self.reading(place) as reader:
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
        with self.reading(self.place(run_id)) as reader:
            rows = read_columns(reader, "tracks", *names, tracks=tracks, confirmed=True)
        return {track: (a, b) for track, a, b in zip(*(rows.ints(name).tolist() for name in names), strict=True)}

    def label(self, run_id: str, track_id: int) -> int | None:
        """The engine's label of a confirmed track, in the video's set; -1: the set lacks the engine's class.

        Returns:
            None: the track was never classified, or does not exist.
        """
        place = self.place(run_id)
        with self.reading(place) as reader:
            rows = read_columns(reader, "tracks", "class_id", tracks=(track_id, track_id), confirmed=True)
        seen = next((number for number in rows.ints("class_id").tolist() if number >= 0), None)
        return None if seen is None else place.classes.to_label(seen)

    # ------------------------------------------------------------------------------------- about frames and tracks

    def overlays(self, run_id: str, first: int, last: int) -> list[Overlay]:
        """Overlays of a window of frames.

        Raises:
            Invalid: the window is empty or too long.
        """
        if not first <= last < first + MOST_FRAMES:
            raise Invalid(f"Request 1 to {MOST_FRAMES} frames. Got {first} to {last}.", field="last")
        place = self.place(run_id)
        if not place.readable():
            return []
        with self.reading(place) as reader:
            return overlays(reader, first, last, place.classes)

    def track(self, run_id: str, track_id: int) -> TrackLane:
        """One track frame by frame.

        Raises:
            NotFound: the run has no such track.
        """
        place = self.place(run_id)
        with self.reading(place) as reader:
            lane = track_lane(reader, track_id, place.classes)
        if lane is None:
            raise NotFound(f"The run has no track {track_id}.")
        return lane

    # ------------------------------------------------------------------------------------------------------ inside

    def _tracks(self, place: RunPlace) -> Model:
        facts = self._facts.get(place.id) if place.complete else None
        if facts is None:
            facts = self._ask(place, track_facts)
            if place.complete:
                with self._lock:
                    self._facts[place.id] = facts
                    while len(self._facts) > 4:
                        self._facts.popitem(last=False)
        facts, words = labelled_facts(facts, place.classes)
        labels = place.classes.labels
        found = self._others.disagreement(place.id, place.video_id, facts, labels) if place.complete else None
        overruled = self._others.overruled(place.id, facts, labels)
        return track_columns(facts, words, found, overruled, place.complete)

    def _ask(self, place: RunPlace, question: Callable[[EvidenceReader], _T]) -> _T:
        with self.reading(place) as reader:
            return question(reader)

    def _cached(self, key: tuple[str, ...], place: RunPlace, make: Callable[[], Model]) -> bytes:
        """Cache an answer: of a complete run for good, of a growing run for each chunk."""
        if not place.complete:
            with self.reading(place) as reader:
                key = (*key, str(reader.last_frame))
        return self._answers.get(key, lambda: _json(make()))


def _json(answer: Model) -> bytes:
    return answer.__pydantic_serializer__.to_json(answer)
