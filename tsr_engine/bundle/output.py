"""Looks up the engine's result rows of a bundle by frame."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TextIO

import numpy as np

from tsr_engine.errors import ImportFormatError
from tsr_engine.evidence import RESULT_HEADER, ResultRow
from tsr_engine.geometry.boxes import iou, non_overlap
from tsr_engine.records import FloatArray

MAX_EDGE_DIFFERENCE_PX = 0.5
"""Largest difference between the edges of equal outputs, px."""


@dataclass(slots=True)
class Output:
    """Confirmed results of the judged frames, as if the video ended with the last of them.

    Attributes:
        first: first judged frame.
        stop: frame after the last.
        rows: by frame, then by track.
    """

    first: int
    stop: int
    rows: list[ResultRow] = field(default_factory=list)
    _boxes: dict[int, tuple[list[int], FloatArray]] = field(default_factory=dict)
    _classes: dict[int, int] = field(default_factory=dict)

    @classmethod
    def from_rows(cls, rows: Iterable[ResultRow], first: int, stop: int) -> Output:
        """The output of rows, without those of other frames."""
        output = cls(first, stop, [row for row in rows if first <= row.frame < stop])
        by_frame: dict[int, list[ResultRow]] = {}
        for row in output.rows:
            by_frame.setdefault(row.frame, []).append(row)
            output._classes[row.track_id] = row.class_id
        for frame, found in by_frame.items():
            output._boxes[frame] = [row.track_id for row in found], np.array([row[2:6] for row in found], np.float64)
        return output

    @property
    def tracks(self) -> list[int]:
        """Numbers of the tracks, ascending."""
        return sorted(self._classes)

    def class_of(self, track: int) -> int:
        """Class of a track over the frames; -1: none."""
        return self._classes.get(track, -1)

    def tracks_on(self, frame: int, box: Sequence[float], min_iou: float) -> list[int]:
        """Tracks with at least this IoU with a box, best first."""
        if frame not in self._boxes:
            return []
        tracks, boxes = self._boxes[frame]
        found = iou(box, boxes)[0]
        order = np.argsort(-found, kind="stable")
        return [tracks[i] for i in order.tolist() if found[i] >= min_iou]

    def error(self, frame: int, box: Sequence[float]) -> float:
        """Eq. 7 of the nearest result, in [0, 1]; 1: no result overlaps the box."""
        if frame not in self._boxes:
            return 1.0
        return float(non_overlap(box, self._boxes[frame][1]).min())


def same_output(a: Output, b: Output) -> bool:
    """Whether two outputs are equal: equal boxes within half a pixel, and equal classes; numbers of tracks may differ.

    Each track of one output must correspond to exactly one of the other.
    """
    if len(a.rows) != len(b.rows):
        return False
    partner: dict[int, int] = {}
    for frame in range(a.first, a.stop):
        boxes_a, boxes_b = a._boxes.get(frame), b._boxes.get(frame)
        if (boxes_a is None) != (boxes_b is None):
            return False
        if boxes_a is None or boxes_b is None:
            continue
        if len(boxes_a[0]) != len(boxes_b[0]):
            return False
        distances = np.abs(boxes_a[1][:, None] - boxes_b[1][None]).max(axis=2)
        for i, track in enumerate(boxes_a[0]):
            j = int(distances[i].argmin())
            other = boxes_b[0][j]
            if distances[i, j] > MAX_EDGE_DIFFERENCE_PX or a.class_of(track) != b.class_of(other):
                return False
            if partner.setdefault(track, other) != other:
                return False
    return max(Counter(partner.values()).values(), default=1) == 1


def write_rows(out: TextIO, rows: Iterable[ResultRow]) -> None:
    """Write rows in the format of ``tsr track --csv`` into an open file."""
    out.write(RESULT_HEADER + "\n")
    out.writelines(row.line() + "\n" for row in rows)


def read_rows(path: Path) -> list[ResultRow]:
    """Invert ``write_rows``.

    Raises:
        ImportFormatError: a line is not in that format.
    """
    rows: list[ResultRow] = []
    lines = numbered_lines(path)
    if ",".join(next(lines, (1, []))[1]) != RESULT_HEADER:
        raise ImportFormatError(f"{path.name}, line 1: expected {RESULT_HEADER}. Create the bundle again.")
    for number, values in lines:
        try:
            frame, track, x1, y1, x2, y2, label, score, source = values
            row = ResultRow(
                int(frame), int(track), float(x1), float(y1), float(x2), float(y2), int(label), float(score), source
            )
        except ValueError:
            raise ImportFormatError(
                f"{path.name}, line {number}: is not a row of results. Create the bundle again."
            ) from None
        if not all(np.isfinite(row[2:6])):
            raise ImportFormatError(f"{path.name}, line {number}: a box is not finite. Create the bundle again.")
        rows.append(row)
    return rows


def numbered_lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """The lines of a table with their numbers from 1.

    Raises:
        ImportFormatError: a line is not values between commas, or a value is too long.
    """
    with path.open(encoding="utf-8", errors="replace", newline="") as stream:
        reader = csv.reader(stream)
        try:
            yield from enumerate(reader, 1)
        except csv.Error as error:
            raise ImportFormatError(
                f"{path.name}, line {reader.line_num}: is not values between commas ({error}). Create the bundle again."
            ) from None
