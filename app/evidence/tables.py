"""Columns straight from a store: what every view of a whole run is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.geometry.boxes import area, clip
from tsr_engine.labels.classes import RunClasses

__all__ = [
    "SOURCES", "BoxTable", "FloatColumn", "IntColumn", "columns", "confirmed_boxes", "labelled_boxes",
    "symmetry_floor_of", "tau_of",
]  # fmt: skip

IntColumn = NDArray[np.int64]
FloatColumn = NDArray[np.float64]

SOURCES = ("detected", "predicted", "relocalised")
"""Names behind the numbers 0, 1, 2."""
SOURCE_SQL = "CASE source WHEN 'detected' THEN 0 WHEN 'predicted' THEN 1 ELSE 2 END"


@dataclass(frozen=True, slots=True)
class BoxTable:
    """Boxes of the tracks of one video, ordered by frame, then by track.

    Attributes:
        frame: shape (n,).
        track: shape (n,), position of the track in ``keys``.
        boxes: shape (n, 4), px.
        class_id: shape (n,), -1: unknown.
        ignore: shape (n,): counts neither as a miss nor as false.
        source: shape (n,), see ``SOURCES``; -1: made by a person.
        keys: name of each track.
    """

    frame: IntColumn
    track: IntColumn
    boxes: FloatColumn
    class_id: IntColumn
    ignore: NDArray[np.bool_]
    source: IntColumn
    keys: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.frame)

    def within(self, first: int, last: int) -> BoxTable:
        """The rows of ``first <= frame <= last``."""
        return self._rows(slice(*np.searchsorted(self.frame, [first, last + 1])))

    def inside(self, width: int, height: int) -> BoxTable:
        """What lies in a picture of that size, px: boxes are cut at its edges, those beyond are left out."""
        cut = replace(self, boxes=clip(self.boxes, width, height))
        return cut._rows(area(cut.boxes) > 0)

    def _rows(self, keep: slice | NDArray[np.bool_]) -> BoxTable:
        return BoxTable(
            self.frame[keep],
            self.track[keep],
            self.boxes[keep],
            self.class_id[keep],
            self.ignore[keep],
            self.source[keep],
            self.keys,
        )


def columns(rows: list[tuple[Any, ...]], width: int) -> FloatColumn:
    """Rows of numbers as an array of shape (width, n), NULL as NaN."""
    flat: FloatColumn
    try:
        flat = np.fromiter(chain.from_iterable(rows), np.float64, len(rows) * width)
    except TypeError:  # a NULL somewhere
        values = (np.nan if value is None else value for value in chain.from_iterable(rows))
        flat = np.fromiter(values, np.float64, len(rows) * width)
    return np.ascontiguousarray(flat.reshape(-1, width).T)


def confirmed_boxes(reader: EvidenceReader) -> BoxTable:
    """All boxes of the confirmed tracks of a run, each with the class fused over its track."""
    labels = {
        row[0]: row[1] for row in reader.query("SELECT track_id, class_id FROM tracks WHERE confirmed_frame >= 0")
    }
    rows = reader.query(
        f"SELECT frame, track_id, x1, y1, x2, y2, {SOURCE_SQL} FROM track_frames "  # noqa: S608
        "WHERE state <> 'dead' ORDER BY frame, track_id"
    )
    table = columns(rows, 7)
    ids = np.array(sorted(labels), dtype=np.int64)
    track = table[1].astype(np.int64)
    place = np.searchsorted(ids, track)
    known = (place < len(ids)) & (ids[np.minimum(place, max(len(ids) - 1, 0))] == track) if len(ids) else track < 0
    known &= np.isfinite(table[2:6]).all(axis=0)
    of_track = np.array([-1 if labels[i] is None else labels[i] for i in ids.tolist()], dtype=np.int64)
    place = place[known]
    return BoxTable(
        frame=table[0].astype(np.int64)[known],
        track=place,
        boxes=np.ascontiguousarray(table[2:6].T[known]),
        class_id=of_track[place] if len(ids) else place,
        ignore=np.zeros(len(place), np.bool_),
        source=table[6].astype(np.int64)[known],
        keys=tuple(f"m{i}" for i in ids.tolist()),
    )


def labelled_boxes(table: BoxTable, classes: RunClasses, unmapped: Callable[[str], int] | None = None) -> BoxTable:
    """Boxes of a run with labels of a set in place of its class numbers.

    Args:
        table: with class numbers.
        classes: what they mean.
        unmapped: the model's own word for a class that the set has no label for -> what stands for it; unset: -1.
    """
    labels = classes.to_labels(table.class_id)
    if unmapped is not None:
        for number in np.unique(table.class_id).tolist():
            if classes.is_unmapped(number):
                labels[table.class_id == number] = unmapped(classes.name(number))
    return replace(table, class_id=labels)


def tau_of(reader: EvidenceReader) -> float:
    """The gate's threshold that the run was made with."""
    return float(reader.header.parameters["gate"]["tau"])


def symmetry_floor_of(reader: EvidenceReader) -> float:
    """The mirror symmetry that the run's gate took for anything below it."""
    return float(reader.header.parameters["gate"]["symmetry_floor"])
