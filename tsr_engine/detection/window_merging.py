"""Merges the windows that pass the cascade into candidates: one per place, at their weighted mean.

Dozens of windows find a sign, and none lies exactly on it, because windows lie on a grid of cells and scales. Their
mean lies nearer to the sign than the best of them. The refine-and-verify stage starts from the mean.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from tsr_engine.detection.nms import suppress
from tsr_engine.geometry.boxes import iou
from tsr_engine.linear_algebra import product
from tsr_engine.records import FloatArray

MIN_MERGE_IOU: Final = 0.6
"""A window counts toward a candidate if it overlaps the candidate's best window by more than this IoU."""
SCORE_SCALE: Final = 12.0
"""Score difference, in half log-odds, that reduces a window's weight to 1/e."""


def merge_windows(
    boxes: FloatArray, scores: FloatArray, overlap: float, limit: int, nested: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Merge windows into candidates.

    Args:
        boxes: windows, shape (n, 4), corners.
        scores: shape (n,), half log-odds.
        overlap: share of the smaller of two windows, in [0, 1]; above it only the better window stays.
        limit: largest number of candidates.
        nested: see :func:`~tsr_engine.detection.nms.suppress`.

    Returns:
        Candidates (m, 4) and their scores (m,), best first, one for each window that suppression keeps. The box is the
        mean of the windows around it, weighted by ``exp(score / SCORE_SCALE)``.
    """
    kept = suppress(boxes, scores, overlap, limit, nested)
    if not len(kept):
        return np.zeros((0, 4)), np.zeros(0)
    is_merged = iou(boxes[kept], boxes) > MIN_MERGE_IOU
    weights = is_merged * np.exp((scores - scores.max()) / SCORE_SCALE)
    return product(weights, boxes) / weights.sum(axis=1, keepdims=True), scores[kept]
