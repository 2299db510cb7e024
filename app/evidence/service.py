"""Answers the routes about a run's evidence."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from sqlalchemy import select

from app.errors import ApiError, Conflict, Invalid, NotFound
from app.evidence.crops import MARGIN, CropOf, box_in_frame, crop_of, encode, pixels_in_frame
from app.evidence.disagreement import Others
from app.evidence.explain import Explanation
from app.evidence.explainer import Explainer, Question
from app.evidence.flips import Flips, flips
from app.evidence.lane import TrackLane, track_lane
from app.evidence.lanes import LaneColumns, lane_columns
from app.evidence.overlays import MOST_FRAMES, Overlay, overlays
from app.evidence.pool import ReaderPool
from app.evidence.tables import BoxTable, confirmed_boxes, labelled_boxes
from app.evidence.tracks import TrackFacts, labelled_facts, no_tracks, track_columns, track_facts
from app.labels.mapping import RunClasses, classes_in
from app.settings import Settings
from app.shapes import Model
from app.storage.database import Database
from app.storage.models import Run, Video
from app.storage.places import is_here, require_here
from app.videos.opened import library_file
from tsr_engine.errors import EvidenceError, TsrError
from tsr_engine.evidence.columns import read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.geometry.boxes import area, clip
from tsr_engine.params import Params
from tsr_engine.records import FloatArray, Picture

__all__ = ["EvidenceService", "RunPlace"]

CACHE_BYTES = 48 * 2**20
"""Memory for finished answers about whole runs."""

Box = tuple[float, float, float, float]
_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class RunPlace:
    """Where a run's evidence lies and how the run stands."""

    id: str
    video_id: str
    folder: Path
    state: str
    parent_id: str | None
    preset: str
    parameters: dict[str, Any]
    classes: RunClasses
    """What the class numbers of the evidence mean in the newest version of the video's label set."""

    @property
    def complete(self) -> bool:
        """Nothing will be added any more."""
        return self.state == "complete"


class EvidenceService:
    """Reads evidence for the page; thread-safe."""

    def __init__(self, settings: Settings, database: Database) -> None:
        self._settings = settings
        self._home = settings.home
        self._database = database
        self._pool = ReaderPool()
        self._explainer = Explainer()
        self._others = Others(database, self.boxes)
        self._lock = threading.Lock()
        self._answers: OrderedDict[tuple[str, ...], bytes] = OrderedDict()
        self._facts: OrderedDict[str, TrackFacts] = OrderedDict()
        self._turns: dict[tuple[str, ...], threading.Lock] = {}

    def close(self) -> None:
        """Close all stores."""
        self._explainer.close()
        self._pool.close()

    def forget(self, run_id: str) -> None:
        """Drop what is kept of a run that was removed."""
        with self._lock:
            for key in [key for key in self._answers if key[1] == run_id]:
                del self._answers[key]
            self._facts.pop(run_id, None)
        self._others.forget(run_id)
        self._pool.forget(self._home / "runs" / run_id)

    def place(self, run_id: str) -> RunPlace:
        """Where a run lies.

        Raises:
            NotFound: there is none of that name.
            Elsewhere: it lies with another server.
        """
        with self._database.read() as session:
            run = session.get(Run, run_id)
            if run is None:
                raise NotFound(f"There is no run {run_id[:40]!r}.")
            require_here(session, run.place, run.name)
            folder = self._home / run.folder
            classes = classes_in(session, run)
            about = run.state, run.parent_id, run.preset, dict(run.parameters)
            return RunPlace(run.id, run.video_id, folder, *about, classes)

    @contextmanager
    def reading(self, place: RunPlace) -> Iterator[EvidenceReader]:
        """A reader of the run.

        Raises:
            Conflict: the run has stored nothing yet.
        """
        if not (place.folder / RUN_FILE).is_file():
            raise Conflict("The run has stored nothing yet. Wait for its first frames.", code="no_evidence")
        with self._pool.reading(place.folder) as reader:
            yield reader

    # ------------------------------------------------------------------------------------------- about whole runs

    def warm(self) -> None:
        """Answer for the newest complete run what the page asks first, so that it opens at once later."""
        with self._database.read() as session:
            ours = Run.state == "complete", is_here(session, Run.place)
            query = select(Run.id).where(*ours).order_by(Run.order.desc()).limit(1)
            newest = session.scalars(query).first()
        if newest is not None:
            with suppress(ApiError, TsrError):  # whoever opens it is reported
                self.lanes(newest)
                self.tracks(newest)

    def tracks(self, run_id: str) -> bytes:
        """``TrackColumns`` as JSON; empty columns while the run has nothing."""
        place = self.place(run_id)
        if not _has_begun(place):
            return _json(no_tracks(_tau(place)))
        others = self._others.version(place.id, place.video_id)
        labels = place.classes.labels
        state = ("tracks", place.id, *others, labels.key, str(labels.version))
        return self._cached(state, place, lambda: self._tracks(place))

    def lanes(self, run_id: str) -> bytes:
        """``LaneColumns`` as JSON."""
        place = self.place(run_id)
        if not _has_begun(place):
            return _json(LaneColumns(track=[], first=[], last=[], source=[]))
        return self._cached(("lanes", place.id), place, lambda: self._ask(place, lane_columns))

    def flips(self, run_id: str, tau: float) -> Flips:
        """What another tau would turn over."""
        place = self.place(run_id)
        with self.reading(place) as reader:
            return flips(reader, tau)

    def boxes(self, run_id: str, unmapped: Callable[[str], int] | None = None) -> BoxTable:
        """All boxes of the run's confirmed tracks, with labels of the video's set.

        Args:
            run_id: the run.
            unmapped: the model's own word for a class that the set has no label for -> what stands for it; unset:
                no label.
        """
        place = self.place(run_id)
        with self.reading(place) as reader:
            return labelled_boxes(confirmed_boxes(reader), place.classes, unmapped)

    def stored_frames(self, run_id: str) -> tuple[int, int] | None:
        """First and last frame that the run has stored; None: none."""
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
        """The engine's label of a confirmed track, in the video's set; -1: the set lacks what the engine calls it.

        Returns:
            None: never recognised, or the run has no such track.
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
            raise Invalid(f"Ask for 1 to {MOST_FRAMES} frames. Got {first} to {last}.", field="last")
        place = self.place(run_id)
        if not _has_begun(place):
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

    def crop(
        self, run_id: str, track_id: int, frame: int, size: int, of: CropOf, picture: Callable[[str, int], Picture]
    ) -> bytes:
        """A track's crop as PNG.

        Args:
            run_id: the run.
            track_id: the track.
            frame: ordinal of the frame.
            size: longer side of the answer, px.
            of: its result, or the prediction that the gate judged, with the gate's margin.
            picture: decodes a frame of a video; asked only where evidence lacks pixels.

        Raises:
            NotFound: the track has no such box there.
        """
        place = self.place(run_id)
        with self.reading(place) as reader:
            box = box_in_frame(reader, track_id, frame, of)
            margin = float(reader.header.parameters["gate"]["gate_margin"]) if of == "prediction" else MARGIN
        if box is None:
            raise NotFound(f"Track {track_id} has no {of} in frame {frame}.")
        return self._crop(place, frame, box, margin, size, picture)

    def crop_of_box(
        self, run_id: str, frame: int, box: Box, size: int, picture: Callable[[str, int], Picture]
    ) -> bytes:
        """What lies under any box in a frame of the run's video, with the margin of a result, as PNG.

        Args:
            run_id: the run.
            frame: ordinal of the frame.
            box: x1, y1, x2, y2, px.
            size: longer side of the answer, px.
            picture: decodes a frame of a video; asked only where evidence lacks pixels.

        Raises:
            NotFound: the box lies beyond the picture.
        """
        place = self.place(run_id)
        with self._database.read() as session:
            video = session.get_one(Video, place.video_id)
        inside = clip(np.array([box], np.float64), video.width or 0, video.height or 0)
        if area(inside)[0] <= 0:
            raise NotFound("The box lies beyond the picture.", field="box")
        return self._crop(place, frame, inside[0], MARGIN, size, picture)

    def _crop(
        self,
        place: RunPlace,
        frame: int,
        box: FloatArray,
        margin: float,
        size: int,
        picture: Callable[[str, int], Picture],
    ) -> bytes:
        with self._pixels_of(place) as source:
            stored = pixels_in_frame(source, frame)
        crop = crop_of(stored, box, margin, lambda: picture(place.video_id, frame))
        return encode(crop, size)

    def explain(self, run_id: str, track_id: int, frame: int) -> Explanation:
        """Why the gate judged one prediction as it did.

        Raises:
            NotFound: it did not judge that track there.
        """
        place = self.place(run_id)
        nothing = NotFound(f"The gate did not judge track {track_id} in frame {frame}.")
        with self.reading(place) as reader, self._pixels_of(place) as source:
            if box_in_frame(reader, track_id, frame, "prediction") is None:
                raise nothing  # also where the run has no such frame
            pixels = source.folder
        with self._database.read() as session:
            file = library_file(self._settings, session.get_one(Video, place.video_id))
        question = Question(
            str(place.folder),
            str(pixels),
            str(file) if file.there else "",
            track_id,
            frame,
            self._settings.max_pixels,
            file.digest or "",
            file.stamp,
            tuple(map(str, file.roots)),
        )
        found = self._explainer.ask(question)
        if found is None:
            raise nothing
        return found

    # ------------------------------------------------------------------------------------------------------ inside

    @contextmanager
    def _pixels_of(self, place: RunPlace) -> Iterator[EvidenceReader]:
        """The store that holds the pixels: a what-if's are those of the run that it replays."""
        if place.parent_id is None:
            with self.reading(place) as reader:
                yield reader
            return
        with self._pixels_of(self.place(place.parent_id)) as reader:
            yield reader

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
        """An answer about a complete run is made once; one about a growing run, once a chunk."""
        if not place.complete:
            with self.reading(place) as reader:
                key = (*key, str(reader.last_frame))
        with self._lock:
            turn = self._turns.setdefault(key, threading.Lock())
        with turn:  # who asks for what is being made already waits for it
            with self._lock:
                known = self._answers.get(key)
                if known is not None:
                    self._answers.move_to_end(key)
                    return known
            try:
                answer = _json(make())
            finally:
                with self._lock:
                    self._turns.pop(key, None)
            return self._keep(key, answer)

    def _keep(self, key: tuple[str, ...], answer: bytes) -> bytes:
        with self._lock:
            # What was known of an earlier state of the same run is of no use any more.
            for old in [k for k in self._answers if k[:2] == key[:2]]:
                del self._answers[old]
            self._answers[key] = answer
            while len(self._answers) > 1 and sum(map(len, self._answers.values())) > CACHE_BYTES:
                self._answers.popitem(last=False)
        return answer


def _has_begun(place: RunPlace) -> bool:
    """Whether a run has stored anything yet.

    Raises:
        Conflict: it has stored all of it, and that is gone.
    """
    begun = (place.folder / RUN_FILE).is_file()
    if place.complete and not begun:
        raise Conflict(f"The run's evidence is not there any more. Put {place.folder} back.", code="evidence_gone")
    return begun


def _json(answer: Model) -> bytes:
    return answer.__pydantic_serializer__.to_json(answer)


def _tau(place: RunPlace) -> float:
    try:
        return Params.preset(place.preset).with_settings(place.parameters.items()).gate.tau
    except EvidenceError:
        return Params().gate.tau
