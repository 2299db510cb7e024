"""Greedy non-maximum suppression."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.records import FloatArray


@njit(cache=True, nogil=True)
def _greedy(boxes, overlap, limit, nested):  # type: ignore[no-untyped-def]
    n = boxes.shape[0]
    keep = np.empty(n, np.int64)
    kept = 0
    dead = np.zeros(n, np.bool_)
    for i in range(n):
        if dead[i]:
            continue
        keep[kept] = i
        kept += 1
        if kept == limit:
            break
        area_i = (boxes[i, 2] - boxes[i, 0]) * (boxes[i, 3] - boxes[i, 1])
        for j in range(i + 1, n):
            if dead[j]:
                continue
            w = min(boxes[i, 2], boxes[j, 2]) - max(boxes[i, 0], boxes[j, 0])
            h = min(boxes[i, 3], boxes[j, 3]) - max(boxes[i, 1], boxes[j, 1])
            if w <= 0 or h <= 0:
                continue
            area_j = (boxes[j, 2] - boxes[j, 0]) * (boxes[j, 3] - boxes[j, 1])
            smaller, larger = min(area_i, area_j), max(area_i, area_j)
            if w * h > overlap * smaller and smaller >= nested * larger:
                dead[j] = True
    return keep[:kept]


def suppress(
    boxes: FloatArray, scores: FloatArray, overlap: float, limit: int = 1000, nested: float = 0.0
) -> NDArray[np.int64]:
    """Indices of the kept boxes, best first.

    A box is dropped if a better kept box overlaps it by more than ``overlap`` of the smaller area of the two (the
    toolbox's ``min`` denominator). Boxes of equal score keep the order of the input.

    Args:
        boxes: shape (n, 4), corners.
        scores: shape (n,).
        overlap: in [0, 1].
        limit: largest number of boxes to keep.
        nested: ratio of areas, smaller to larger, below which two boxes do not suppress each other, since a sign may
            contain a sign. In [0, 1].
    """
    order = np.argsort(-scores, kind="stable")
    return np.asarray(order[_greedy(np.ascontiguousarray(boxes[order], np.float64), overlap, limit, nested)])
