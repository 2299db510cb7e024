"""Matches boxes of two tables that overlap, in all frames at once."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from app.evidence.tables import BoxTable, FloatColumn, IntColumn

__all__ = ["Pairs", "box_pairs", "overlap"]

_AT_ONCE: Final = 1 << 20
"""Pairs that are looked at together, so that their memory is bounded."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of rows of one frame each, by frame.

    Attributes:
        a: shape (n,), row of the first table.
        b: shape (n,), row of the second.
        iou: shape (n,), in [0, 1].
    """

    a: IntColumn
    b: IntColumn
    iou: FloatColumn


def box_pairs(first: BoxTable, second: BoxTable, least: float) -> Pairs:
    """All pairs of one frame with an IoU of at least ``least``; both tables are ordered by frame.

    Pairs of one frame are as many as the product of its boxes, so they are looked at a piece at a time.
    """
    low = np.searchsorted(second.frame, first.frame, side="left")
    count = np.searchsorted(second.frame, first.frame, side="right") - low
    ends = (
        np.searchsorted(np.cumsum(count), np.arange(_AT_ONCE, int(count.sum()) + _AT_ONCE, _AT_ONCE), side="left") + 1
    )
    bounds = np.unique(np.concatenate([[0], np.minimum(ends, len(first)), [len(first)]]))
    pieces = [_pairs_of(first, second, low, count, slice(a, b), least) for a, b in pairwise(bounds.tolist())]
    return (
        Pairs(*(np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("a", "b", "iou")))
        if pieces
        else Pairs(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))
    )


def _pairs_of(first: BoxTable, second: BoxTable, low: IntColumn, count: IntColumn, rows: slice, least: float) -> Pairs:
    """Those of some rows of the first table."""
    low, count = low[rows], count[rows]
    a = np.repeat(np.arange(rows.start, rows.stop), count)
    inside = np.arange(len(a)) - np.repeat(np.cumsum(count) - count, count)
    b = np.repeat(low, count) + inside
    inter, area_a, area_b = overlap(first.boxes[a], second.boxes[b])
    union = area_a + area_b - inter
    iou = np.divide(inter, union, out=np.zeros_like(inter), where=union > 0)
    keep = iou >= least
    return Pairs(a[keep], b[keep], iou[keep])


def overlap(a: FloatColumn, b: FloatColumn) -> tuple[FloatColumn, FloatColumn, FloatColumn]:
    """Areas of intersection and of both boxes, row by row; shape (n,) each."""
    sides = np.minimum(a[:, 2:], b[:, 2:]) - np.maximum(a[:, :2], b[:, :2])
    inter = np.prod(np.maximum(sides, 0.0), axis=1)
    return (
        inter,
        np.prod(np.maximum(a[:, 2:] - a[:, :2], 0), axis=1),
        np.prod(np.maximum(b[:, 2:] - b[:, :2], 0), axis=1),
    )
