"""Which boxes of two tables lie on each other, in all frames at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.evidence.tables import BoxTable, FloatColumn, IntColumn

__all__ = ["Pairs", "box_pairs", "overlap"]


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
    """All pairs of one frame with an IoU of at least ``least``; both tables are ordered by frame."""
    low = np.searchsorted(second.frame, first.frame, side="left")
    count = np.searchsorted(second.frame, first.frame, side="right") - low
    a = np.repeat(np.arange(len(first)), count)
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
