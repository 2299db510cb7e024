"""The confirmed tracks of a run, straight from its evidence, one after the other, a few hundred in memory at a time."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.edits.documents import TrackDoc
from app.evidence.tables import FloatColumn, IntColumn, columns
from tsr_engine.evidence.reader import EvidenceReader

__all__ = ["EngineFacts", "EngineTrack", "EngineTracks", "as_it_is", "engine_facts", "engine_label"]

_BLOCK = 256
_ROWS = "SELECT track_id, frame, x1, y1, x2, y2, score FROM track_frames WHERE state <> 'dead' AND track_id"


@dataclass(frozen=True, slots=True)
class EngineTrack:
    """One track of the engine, or of an imported run.

    Attributes:
        id: its number.
        label: of the whole track; -1: never recognised, or a class that the set has no label for.
        frames: ascending, shape (n,).
        boxes: shape (n, 4), px.
        score: 0 to 1, NaN where there is none, shape (n,): the logistic of the stored log-odds.
    """

    id: int
    label: int
    frames: IntColumn
    boxes: FloatColumn
    score: FloatColumn


def as_it_is(class_number: int) -> int:
    """Classes that are ids of labels already."""
    return class_number


class EngineTracks:
    """Reads tracks in order of their numbers, or one by its number."""

    def __init__(self, reader: EvidenceReader, to_label: Callable[[int], int] = as_it_is) -> None:
        self._reader = reader
        sql = "SELECT track_id, class_id FROM tracks WHERE confirmed_frame IS NOT NULL ORDER BY track_id"
        self.labels: dict[int, int] = {row[0]: -1 if row[1] is None else to_label(row[1]) for row in reader.query(sql)}

    def __iter__(self) -> Iterator[EngineTrack]:
        ids = list(self.labels)
        for start in range(0, len(ids), _BLOCK):
            block = ids[start : start + _BLOCK]
            rows = self._reader.query(f"{_ROWS} BETWEEN ? AND ? ORDER BY track_id, frame", (block[0], block[-1]))
            table = columns(rows, 7)
            bounds = np.searchsorted(table[0], [*block, block[-1] + 1])
            ends = np.searchsorted(table[0], block, side="right")
            for number, first, stop in zip(block, bounds[:-1].tolist(), ends.tolist(), strict=True):
                yield self._track(number, table[:, first:stop])

    def chosen(self, numbers: Collection[int]) -> Iterator[EngineTrack]:
        """Those of some numbers that there are, in order of their numbers."""
        for number in sorted(numbers):
            if (track := self.one(number)) is not None:
                yield track

    def one(self, number: int) -> EngineTrack | None:
        """One track; None: there is none of that number."""
        if number not in self.labels:
            return None
        return self._track(number, columns(self._reader.query(f"{_ROWS} = ? ORDER BY frame", (number,)), 7))

    def _track(self, number: int, table: FloatColumn) -> EngineTrack:
        table = table[:, np.isfinite(table[2:6]).all(axis=0)]
        with np.errstate(over="ignore"):
            score = 1.0 / (1.0 + np.exp(-table[6]))
        boxes = np.ascontiguousarray(table[2:6].T)
        return EngineTrack(number, self.labels[number], table[1].astype(np.int64), boxes, score)


@dataclass(frozen=True, slots=True)
class EngineFacts:
    """What is known of a confirmed track without its boxes.

    Attributes:
        label: class of the whole track; -1: never recognised.
        span: first and last frame.
    """

    label: int
    span: tuple[int, int]


def engine_facts(folder: Path, to_label: Callable[[int], int] = as_it_is) -> dict[int, EngineFacts]:
    """All confirmed tracks of a run, by number.

    Args:
        folder: its evidence.
        to_label: class number of the evidence -> id of a label, -1: none.
    """
    sql = "SELECT track_id, class_id, first_frame, last_frame FROM tracks WHERE confirmed_frame IS NOT NULL"
    with EvidenceReader(folder) as reader:
        return {
            row[0]: EngineFacts(-1 if row[1] is None else to_label(row[1]), (row[2], row[3]))
            for row in reader.query(sql)
        }


def engine_label(document: TrackDoc, labels: Mapping[int, int]) -> int | None:
    """The engine's class of a document's own track, else of its first piece; None: it has no track of the engine's.

    Args:
        document: of the track.
        labels: class of each of the engine's tracks, by number; -1: never recognised.
    """
    own = [int(document.key[1:])] if document.key.startswith("m") else []
    return next((labels[n] for n in (*own, *(s.track for s in document.segments)) if n in labels), None)
