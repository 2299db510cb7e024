"""Matches boxes of a candidate with those of a reference, for tracking figures and comparisons.

In each frame, candidate boxes are assigned to counted reference boxes with the largest total IoU. A sign keeps the
track of its last matched frame as long as both overlap enough (as in CLEAR MOT). A candidate box without a match is
excused if it lies on an ignored box.

In nearly all frames every box has at most one partner. These frames are matched together, and only the others one by
one, so that a drive of an hour takes a second.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from tsr_engine.geometry.boxes import area, intersection_each, iou_each, non_overlap_each
from tsr_engine.records import FloatArray
from tsr_engine.track_table import BoolArray, IntArray, TrackTable

__all__ = ["Matching", "Pairs", "box_pairs", "match"]

_KEPT: Final = 10.0
"""Bonus of a kept pair; it outweighs any number of new pairs."""
_TOUCHING: Final = 1e-12
"""Least IoU of boxes that overlap at all."""
_AT_ONCE: Final = 1 << 20
"""Number of pairs to compute together, to limit memory."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of rows with the same frame, sorted by frame.

    Attributes:
        a: shape (n,), row of the first table.
        b: shape (n,), row of the second.
        iou: shape (n,), in [0, 1].
    """

    a: IntArray
    b: IntArray
    iou: FloatArray


@dataclass(frozen=True, slots=True)
class Matching:
    """The result of matching two tables.

    Attributes:
        reference: shape (m,), matched rows of the reference, sorted by frame.
        candidate: shape (m,), the candidate's row of each match.
        error: shape (m,), Eq. 7 of each match, in [0, 1].
        missed: shape (r,), counted reference rows without a match.
        false: shape (c,), candidate rows that neither match nor are excused.
        counted: number of counted reference rows.
        judged: number of candidate rows that are not excused.
    """

    reference: IntArray
    candidate: IntArray
    error: FloatArray
    missed: IntArray
    false: IntArray
    counted: int
    judged: int


def box_pairs(first: TrackTable, second: TrackTable, least: float) -> Pairs:
    """All pairs of rows of the same frame with an IoU of at least ``least``; both tables must be sorted by frame.

    The number of pairs of a frame is the product of its numbers of boxes, so they are computed in pieces.
    """
    low = np.searchsorted(second.frame, first.frame, side="left")
    count = np.searchsorted(second.frame, first.frame, side="right") - low
    ends = (
        np.searchsorted(np.cumsum(count), np.arange(_AT_ONCE, int(count.sum()) + _AT_ONCE, _AT_ONCE), side="left") + 1
    )
    bounds = np.unique(np.concatenate([[0], np.minimum(ends, len(first)), [len(first)]]))
    pieces = [_pairs_of(first, second, low, count, slice(a, b), least) for a, b in pairwise(bounds.tolist())]
    if not pieces:
        return Pairs(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))
    return Pairs(*(np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("a", "b", "iou")))


def _pairs_of(
    first: TrackTable, second: TrackTable, low: IntArray, count: IntArray, rows: slice, least: float
) -> Pairs:
    """The pairs of some rows of the first table."""
    low, count = low[rows], count[rows]
    a = np.repeat(np.arange(rows.start, rows.stop), count)
    inside = np.arange(len(a)) - np.repeat(np.cumsum(count) - count, count)
    b = np.repeat(low, count) + inside
    iou = iou_each(first.boxes[a], second.boxes[b])
    keep = iou >= least
    return Pairs(a[keep], b[keep], iou[keep])


def match(reference: TrackTable, candidate: TrackTable, least: float = 0.5) -> Matching:
    """Match two tables, which must be sorted by frame; ``least`` is the least IoU of a match."""
    pairs = box_pairs(reference, candidate, max(least, _TOUCHING))
    counted = ~reference.ignore[pairs.a]
    r, c = _assign(reference, candidate, Pairs(pairs.a[counted], pairs.b[counted], pairs.iou[counted]))
    hit = np.zeros(len(reference), np.bool_)
    hit[r] = True
    matched = np.zeros(len(candidate), np.bool_)
    matched[c] = True
    excused = (_excused(reference, candidate, least) | candidate.ignore) & ~matched
    return Matching(
        reference=r,
        candidate=c,
        error=non_overlap_each(reference.boxes[r], candidate.boxes[c]),
        missed=np.flatnonzero(~hit & ~reference.ignore),
        false=np.flatnonzero(~matched & ~excused),
        counted=int((~reference.ignore).sum()),
        judged=int((~excused).sum()),
    )


def _assign(reference: TrackTable, candidate: TrackTable, pairs: Pairs) -> tuple[IntArray, IntArray]:
    frame = reference.frame[pairs.a]
    lone = (np.bincount(pairs.a, minlength=1)[pairs.a] == 1) & (np.bincount(pairs.b, minlength=1)[pairs.b] == 1)
    crowded = np.unique(frame[~lone])
    if not len(crowded):
        return pairs.a, pairs.b
    keep = np.ones(len(pairs.a), np.bool_)
    held: dict[int, int] = {}
    sign, track = reference.track[pairs.a].tolist(), candidate.track[pairs.b].tolist()
    starts = np.searchsorted(frame, crowded, side="left").tolist()
    ends = np.searchsorted(frame, crowded, side="right").tolist()
    done = 0
    for start, end in zip(starts, ends, strict=True):
        for i in range(done, start):
            held[sign[i]] = track[i]
        chosen = _best(pairs, slice(start, end), sign, track, held)
        keep[start:end] = chosen
        for i in (start + np.flatnonzero(chosen)).tolist():
            held[sign[i]] = track[i]
        done = end
    return pairs.a[keep], pairs.b[keep]


def _best(pairs: Pairs, rows: slice, sign: list[int], track: list[int], held: dict[int, int]) -> BoolArray:
    """Whether each of one frame's pairs belongs to the assignment with the largest total."""
    from scipy.optimize import linear_sum_assignment  # slow to import, and most comparisons do not need it

    signs, i = np.unique(pairs.a[rows], return_inverse=True)
    boxes, j = np.unique(pairs.b[rows], return_inverse=True)
    gain = np.zeros((len(signs), len(boxes)))
    kept = [held.get(sign[k]) == track[k] for k in range(rows.start, rows.stop)]
    gain[i, j] = pairs.iou[rows] + _KEPT * np.array(kept)
    chosen = np.zeros(gain.shape, np.bool_)
    chosen[linear_sum_assignment(-gain)] = True
    picked: BoolArray = chosen[i, j]
    return picked


def _excused(reference: TrackTable, candidate: TrackTable, least: float) -> BoolArray:
    """Whether each candidate row lies on an ignored box, by IoU or by the covered share of its area."""
    excused = np.zeros(len(candidate), np.bool_)
    if not reference.ignore.any():
        return excused
    near = box_pairs(reference, candidate, _TOUCHING)
    keep = reference.ignore[near.a]
    a, b, iou = near.a[keep], near.b[keep], near.iou[keep]
    boxes = candidate.boxes[b]
    share = intersection_each(reference.boxes[a], boxes) / np.maximum(area(boxes), 1e-9)
    excused[b[np.maximum(iou, share) >= least]] = True
    return excused
