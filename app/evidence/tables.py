"""Reads columns of a store, for every view of a whole run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tsr_engine.evidence.columns import BOX, read_columns
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.geometry.boxes import area, clip
from tsr_engine.labels.classes import RunClasses

__all__ = [
    "BoxTable", "FloatColumn", "IntColumn", "confirmed_boxes", "labelled_boxes", "symmetry_floor_of", "tau_of",
]  # fmt: skip

IntColumn = NDArray[np.int64]
FloatColumn = NDArray[np.float64]


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


def confirmed_boxes(reader: EvidenceReader) -> BoxTable:
    """All boxes of the confirmed tracks of a run, each with the class fused over its track."""
    of_track = read_columns(reader, "tracks", "track_id", "class_id", confirmed=True)
    ids, labels = of_track.ints("track_id"), of_track.ints("class_id")
    rows = read_columns(
        reader, "track_frames", "frame", "track_id", *BOX, "source", alive=True, confirmed=True, order="any"
    )
    track, boxes = rows.ints("track_id"), rows.boxes()
    known = np.isfinite(boxes).all(axis=1)
    order = np.flatnonzero(known)[np.lexsort((track[known], rows.ints("frame")[known]))]
    place = np.searchsorted(ids, track[order])
    return BoxTable(
        frame=rows.ints("frame")[order],
        track=place,
        boxes=boxes[order],
        class_id=labels[place],
        ignore=np.zeros(len(place), np.bool_),
        source=rows.sources()[order],
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
