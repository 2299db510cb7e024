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

_CONTINUITY_BONUS: Final = 10.0
"""Bonus of a kept pair; it outweighs any number of new pairs."""
_MIN_OVERLAP: Final = 1e-12
"""Least IoU of boxes that overlap at all."""
_PAIRS_PER_CHUNK: Final = 1 << 20
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


def box_pairs(first: TrackTable, second: TrackTable, min_iou: float) -> Pairs:
    """All pairs of rows of the same frame with an IoU of at least ``min_iou``; both tables must be sorted by frame.

    The number of pairs of a frame is the product of its numbers of boxes, so they are computed in pieces.
    """
    low = np.searchsorted(second.frame, first.frame, side="left")
    count = np.searchsorted(second.frame, first.frame, side="right") - low
    ends = (
        np.searchsorted(
            np.cumsum(count),
            np.arange(_PAIRS_PER_CHUNK, int(count.sum()) + _PAIRS_PER_CHUNK, _PAIRS_PER_CHUNK),
            side="left",
        )
        + 1
    )
    bounds = np.unique(np.concatenate([[0], np.minimum(ends, len(first)), [len(first)]]))
    chunks = [_pairs_of(first, second, low, count, slice(a, b), min_iou) for a, b in pairwise(bounds.tolist())]
    if not chunks:
        return Pairs(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))
    return Pairs(*(np.concatenate([getattr(chunk, name) for chunk in chunks]) for name in ("a", "b", "iou")))


def _pairs_of(
    first: TrackTable, second: TrackTable, low: IntArray, count: IntArray, rows: slice, min_iou: float
) -> Pairs:
    """The pairs of some rows of the first table."""
    low, count = low[rows], count[rows]
    a = np.repeat(np.arange(rows.start, rows.stop), count)
    offset = np.arange(len(a)) - np.repeat(np.cumsum(count) - count, count)
    b = np.repeat(low, count) + offset
    iou = iou_each(first.boxes[a], second.boxes[b])
    keep = iou >= min_iou
    return Pairs(a[keep], b[keep], iou[keep])


def match(reference: TrackTable, candidate: TrackTable, min_iou: float = 0.5) -> Matching:
    """Match two tables, which must be sorted by frame; ``min_iou`` is the least IoU of a match."""
    pairs = box_pairs(reference, candidate, max(min_iou, _MIN_OVERLAP))
    is_counted = ~reference.ignore[pairs.a]
    r, c = _assign(reference, candidate, Pairs(pairs.a[is_counted], pairs.b[is_counted], pairs.iou[is_counted]))
    is_matched_reference = np.zeros(len(reference), np.bool_)
    is_matched_reference[r] = True
    is_matched = np.zeros(len(candidate), np.bool_)
    is_matched[c] = True
    is_excused = (_lies_on_ignored(reference, candidate, min_iou) | candidate.ignore) & ~is_matched
    return Matching(
        reference=r,
        candidate=c,
        error=non_overlap_each(reference.boxes[r], candidate.boxes[c]),
        missed=np.flatnonzero(~is_matched_reference & ~reference.ignore),
        false=np.flatnonzero(~is_matched & ~is_excused),
        counted=int((~reference.ignore).sum()),
        judged=int((~is_excused).sum()),
    )


def _assign(reference: TrackTable, candidate: TrackTable, pairs: Pairs) -> tuple[IntArray, IntArray]:
    frame = reference.frame[pairs.a]
    is_isolated = (np.bincount(pairs.a, minlength=1)[pairs.a] == 1) & (np.bincount(pairs.b, minlength=1)[pairs.b] == 1)
    crowded = np.unique(frame[~is_isolated])
    if not len(crowded):
        return pairs.a, pairs.b
    keep = np.ones(len(pairs.a), np.bool_)
    last_track: dict[int, int] = {}
    sign, track = reference.track[pairs.a].tolist(), candidate.track[pairs.b].tolist()
    starts = np.searchsorted(frame, crowded, side="left").tolist()
    ends = np.searchsorted(frame, crowded, side="right").tolist()
    next_pair = 0
    for start, end in zip(starts, ends, strict=True):
        for i in range(next_pair, start):
            last_track[sign[i]] = track[i]
        chosen = _best_pairs(pairs, slice(start, end), sign, track, last_track)
        keep[start:end] = chosen
        for i in (start + np.flatnonzero(chosen)).tolist():
            last_track[sign[i]] = track[i]
        next_pair = end
    return pairs.a[keep], pairs.b[keep]


def _best_pairs(pairs: Pairs, rows: slice, sign: list[int], track: list[int], last_track: dict[int, int]) -> BoolArray:
    """Whether each of one frame's pairs belongs to the assignment with the largest total."""
    from scipy.optimize import linear_sum_assignment  # slow to import, and most comparisons do not need it

    signs, i = np.unique(pairs.a[rows], return_inverse=True)
    boxes, j = np.unique(pairs.b[rows], return_inverse=True)
    gain = np.zeros((len(signs), len(boxes)))
    is_continued = [last_track.get(sign[k]) == track[k] for k in range(rows.start, rows.stop)]
    gain[i, j] = pairs.iou[rows] + _CONTINUITY_BONUS * np.array(is_continued)
    chosen = np.zeros(gain.shape, np.bool_)
    chosen[linear_sum_assignment(-gain)] = True
    picked: BoolArray = chosen[i, j]
    return picked


def _lies_on_ignored(reference: TrackTable, candidate: TrackTable, min_iou: float) -> BoolArray:
    """Whether each candidate row lies on an ignored box, by IoU or by the covered share of its area."""
    is_ignored = np.zeros(len(candidate), np.bool_)
    if not reference.ignore.any():
        return is_ignored
    overlapping = box_pairs(reference, candidate, _MIN_OVERLAP)
    keep = reference.ignore[overlapping.a]
    a, b, iou = overlapping.a[keep], overlapping.b[keep], overlapping.iou[keep]
    boxes = candidate.boxes[b]
    share = intersection_each(reference.boxes[a], boxes) / np.maximum(area(boxes), 1e-9)
    is_ignored[b[np.maximum(iou, share) >= min_iou]] = True
    return is_ignored
