"""Reads the confirmed tracks of a run from its evidence one by one, with a few hundred in memory at a time."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.edits.documents import TrackDoc
from app.evidence.run_columns import FloatColumn, IntColumn
from tsr_engine.evidence.columns import BOX, read_columns
from tsr_engine.evidence.reader import EvidenceReader

_BLOCK = 256


@dataclass(frozen=True, slots=True)
class EngineTrack:
    """One track of the engine, or of an imported run.

    Attributes:
        id: its number.
        label: label of the whole track; -1: not classified, or a class without a label in the set.
        frames: ascending, shape (n,).
        boxes: shape (n, 4), px.
        score: shape (n,), in [0, 1]: the logistic of the stored log-odds; NaN: there is none.
    """

    id: int
    label: int
    frames: IntColumn
    boxes: FloatColumn
    score: FloatColumn


def unchanged(class_number: int) -> int:
    """Return class numbers unchanged, for classes that are label ids already."""
    return class_number


class EngineTracks:
    """Reads tracks in order of their numbers, or one by its number."""

    def __init__(self, reader: EvidenceReader, to_label: Callable[[int], int] = unchanged) -> None:
        self._reader = reader
        self.labels = {number: info.label for number, info in _track_infos(reader, to_label).items()}

    def __iter__(self) -> Iterator[EngineTrack]:
        ids = list(self.labels)
        for start in range(0, len(ids), _BLOCK):
            yield from self._read(ids[start : start + _BLOCK])

    def chosen(self, numbers: Collection[int]) -> Iterator[EngineTrack]:
        """Yield the existing tracks among some numbers, in order of their numbers."""
        for number in sorted(numbers):
            if (track := self.track(number)) is not None:
                yield track

    def track(self, number: int) -> EngineTrack | None:
        """Return one track; None: no such track."""
        if number not in self.labels:
            return None
        return next(self._read([number]))

    def _read(self, wanted: list[int]) -> Iterator[EngineTrack]:
        names = ("track_id", "frame", *BOX, "score")
        rows = read_columns(
            self._reader, "track_frames", *names, tracks=(wanted[0], wanted[-1]), alive=True, order="track"
        )
        boxes = rows.boxes()
        known = np.isfinite(boxes).all(axis=1)
        track, frames, boxes = rows.ints("track_id")[known], rows.ints("frame")[known], boxes[known]
        with np.errstate(over="ignore"):
            score = 1.0 / (1.0 + np.exp(-rows.floats("score")[known]))
        starts, stops = np.searchsorted(track, wanted), np.searchsorted(track, wanted, side="right")
        for number, start, stop in zip(wanted, starts.tolist(), stops.tolist(), strict=True):
            at = slice(start, stop)
            yield EngineTrack(number, self.labels[number], frames[at], boxes[at], score[at])


@dataclass(frozen=True, slots=True)
class EngineTrackInfo:
    """A confirmed track without its boxes.

    Attributes:
        label: label of the whole track; -1: not classified.
        span: first and last frame.
    """

    label: int
    span: tuple[int, int]


def read_track_infos(folder: Path, to_label: Callable[[int], int] = unchanged) -> dict[int, EngineTrackInfo]:
    """Read all confirmed tracks of a run, by number.

    Args:
        folder: its evidence.
        to_label: maps a class number of the evidence to a label id, -1: none.
    """
    with EvidenceReader(folder) as reader:
        return _track_infos(reader, to_label)


def _track_infos(reader: EvidenceReader, to_label: Callable[[int], int]) -> dict[int, EngineTrackInfo]:
    names = ("track_id", "class_id", "first_frame", "last_frame")
    rows = read_columns(reader, "tracks", *names, confirmed=True)
    return {
        number: EngineTrackInfo(-1 if class_number < 0 else to_label(class_number), (first, last))
        for number, class_number, first, last in zip(*(rows.ints(name).tolist() for name in names), strict=True)
    }


def engine_label(document: TrackDoc, labels: Mapping[int, int]) -> int | None:
    """Return the engine's class of a document's own track, or of its first segment; None: it has no engine track.

    Args:
        document: the document.
        labels: class of each engine track, by number; -1: not classified.
    """
    own_numbers = [int(document.key[1:])] if document.key.startswith("m") else []
    return next((labels[n] for n in (*own_numbers, *(s.track for s in document.segments)) if n in labels), None)
