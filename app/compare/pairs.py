"""The boxes of both sides at a place of a comparison, which the page draws over its crop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.body_model import Model
from app.evidence.run_columns import FloatColumn
from tsr_engine.geometry.boxes import iou
from tsr_engine.track_table import TrackTable

Sides = tuple[float, float, float, float]


class Pair(Model):
    """The box of a place, and the other side's box there: its partner, or else the box that overlaps it most."""

    box: Sides
    label: int
    """-1: a sign of none of the set's labels; below: see ``words`` of the matrix."""
    other: str | None
    """Track of the other side; None: none of its boxes overlaps."""
    other_box: Sides | None
    other_label: int | None
    iou: float
    """Intersection over union of the two, in [0, 1]; 0 if there is no other box."""


class PairFinder:
    """Finds the pairs of places on one side's tracks.

    Args:
        own: the side whose tracks the places name, ordered by frame.
        other: the other side, ordered by frame.
    """

    def __init__(self, own: TrackTable, other: TrackTable) -> None:
        self._own, self._other = own, other
        self._number = {key: i for i, key in enumerate(own.names)}
        codes = own.frame * max(1, len(own.names)) + own.track
        self._order = np.argsort(codes, kind="stable")
        self._codes = codes[self._order]

    def at(self, frames: Sequence[int], tracks: Sequence[str], partners: Sequence[str | None]) -> list[Pair]:
        """The pair of each place, given its first frame, its track and the other side's track there."""
        places = zip(frames, tracks, partners, strict=True)
        return [self._pair(frame, self._number[track], partner) for frame, track, partner in places]

    def _pair(self, frame: int, track: int, partner: str | None) -> Pair:
        code = frame * len(self._own.names) + track
        row = int(self._order[np.searchsorted(self._codes, code)])
        box, label = self._own.boxes[row], int(self._own.class_id[row])
        low, high = np.searchsorted(self._other.frame, [frame, frame + 1])
        overlap = iou(box, self._other.boxes[low:high])[0]
        keys = [self._other.names[t] for t in self._other.track[low:high].tolist()]
        best = keys.index(partner) if partner is not None else int(overlap.argmax()) if len(overlap) else -1
        if best < 0 or overlap[best] == 0:
            return Pair(box=_sides(box), label=label, other=None, other_box=None, other_label=None, iou=0.0)
        return Pair(
            box=_sides(box),
            label=label,
            other=keys[best],
            other_box=_sides(self._other.boxes[low + best]),
            other_label=int(self._other.class_id[low + best]),
            iou=round(float(overlap[best]), 4),
        )


def _sides(box: FloatColumn) -> Sides:
    x1, y1, x2, y2 = (round(float(side), 2) for side in box)
    return x1, y1, x2, y2
