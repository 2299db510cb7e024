"""Merges the windows that pass the cascade to candidates: one per place, at their weighted mean.

Dozens of windows find a sign, and none lies exactly on it, because they stand on a grid of cells and scales. Their mean
lies nearer than the best of them. The refine-and-verify stage starts there.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from tsr_engine.detection.nms import suppress
from tsr_engine.geometry.boxes import iou
from tsr_engine.products import product
from tsr_engine.records import FloatArray

__all__ = ["SPREAD", "TOGETHER", "merge"]

TOGETHER: Final = 0.6
"""Windows that overlap a kept one by more than this (IoU) count for its place."""
SPREAD: Final = 12.0
"""A window whose score is lower by this, in units of half log-odds, counts 1/e of the best one's."""


def merge(
    boxes: FloatArray, scores: FloatArray, overlap: float, limit: int, nested: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Candidates (m, 4) and their scores (m,), best first.

    Args:
        boxes: windows, shape (n, 4), corners.
        scores: shape (n,).
        overlap: share of the smaller of two windows from which the better one stands for both, in [0, 1].
        limit: most candidates.
        nested: see :func:`~tsr_engine.detection.nms.suppress`.

    Returns:
        For each window that greedy suppression keeps its score and the mean of the windows around it, weighted by
        ``exp(score / SPREAD)``.
    """
    kept = suppress(boxes, scores, overlap, limit, nested)
    if not len(kept):
        return np.zeros((0, 4)), np.zeros(0)
    near = iou(boxes[kept], boxes) > TOGETHER
    weights = near * np.exp((scores - scores.max()) / SPREAD)
    return product(weights, boxes) / weights.sum(axis=1, keepdims=True), scores[kept]
