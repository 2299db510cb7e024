"""Which boxes of a candidate are which boxes of a reference; the rule of ``tsr_engine.evaluation.tracking``.

In each frame candidate boxes are assigned to counted reference boxes with the largest total IoU; a sign keeps the
track that it had in its last matched frame while that still overlaps enough (as in CLEAR MOT). What is left over is
excused where an ignored box explains it.

Nearly all frames have no choice to make: every box there has at most one partner. Those are matched all at once, and
only the others one by one, so that a drive of an hour takes a second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.evidence.overlap import Pairs, box_pairs, overlap
from app.evidence.tables import BoxTable, FloatColumn, IntColumn

__all__ = ["Matching", "match"]

_KEPT = 10.0
"""A kept pair outweighs any number of new ones."""


@dataclass(frozen=True, slots=True)
class Matching:
    """The outcome.

    Attributes:
        reference: shape (m,), rows of the reference, by frame.
        candidate: shape (m,), the row of the candidate matched to each.
        error: shape (m,), Eq. 7 of each match, in [0, 1].
        missed: shape (r,), counted reference rows without a match.
        false: shape (c,), candidate rows that neither match nor are excused.
        counted: number of counted reference rows.
        judged: number of candidate rows that are not excused.
    """

    reference: IntColumn
    candidate: IntColumn
    error: FloatColumn
    missed: IntColumn
    false: IntColumn
    counted: int
    judged: int


def match(reference: BoxTable, candidate: BoxTable, least: float = 0.5) -> Matching:
    """Match two tables over the frames that they hold; both are ordered by frame."""
    pairs = box_pairs(reference, candidate, least)
    counted = ~reference.ignore[pairs.a]
    r, c = _assign(reference, candidate, Pairs(pairs.a[counted], pairs.b[counted], pairs.iou[counted]))
    inter, area_r, area_c = overlap(reference.boxes[r], candidate.boxes[c])
    larger = np.maximum(area_r, area_c)
    error = 1.0 - np.divide(inter, larger, out=np.zeros_like(inter), where=larger > 0)
    hit = np.zeros(len(reference), np.bool_)
    hit[r] = True
    matched = np.zeros(len(candidate), np.bool_)
    matched[c] = True
    excused = (_excused(reference, candidate, least) | candidate.ignore) & ~matched
    return Matching(
        reference=r,
        candidate=c,
        error=error,
        missed=np.flatnonzero(~hit & ~reference.ignore),
        false=np.flatnonzero(~matched & ~excused),
        counted=int((~reference.ignore).sum()),
        judged=int((~excused).sum()),
    )


def _assign(reference: BoxTable, candidate: BoxTable, pairs: Pairs) -> tuple[IntColumn, IntColumn]:
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


def _best(pairs: Pairs, rows: slice, sign: list[int], track: list[int], held: dict[int, int]) -> NDArray[np.bool_]:
    """Which of one frame's pairs are the assignment with the largest total."""
    from scipy.optimize import linear_sum_assignment  # large, and most comparisons never need it

    signs, i = np.unique(pairs.a[rows], return_inverse=True)
    boxes, j = np.unique(pairs.b[rows], return_inverse=True)
    gain = np.zeros((len(signs), len(boxes)))
    kept = [held.get(sign[k]) == track[k] for k in range(rows.start, rows.stop)]
    gain[i, j] = pairs.iou[rows] + _KEPT * np.array(kept)
    chosen = np.zeros(gain.shape, np.bool_)
    chosen[linear_sum_assignment(-gain)] = True
    picked: NDArray[np.bool_] = chosen[i, j]
    return picked


def _excused(reference: BoxTable, candidate: BoxTable, least: float) -> NDArray[np.bool_]:
    """Candidate rows that lie on an ignored box: by IoU, or by the share of their own area."""
    excused = np.zeros(len(candidate), np.bool_)
    if not reference.ignore.any():
        return excused
    near = box_pairs(reference, candidate, 1e-12)
    keep = reference.ignore[near.a]
    a, b, iou = near.a[keep], near.b[keep], near.iou[keep]
    inter, _, own = overlap(reference.boxes[a], candidate.boxes[b])
    excused[b[np.maximum(iou, inter / np.maximum(own, 1e-9)) >= least]] = True
    return excused
