"""Boxes: conversions, overlaps and the paper's localisation error.

A box is ``x1, y1, x2, y2`` in pixel-edge coordinates; arrays of boxes have shape (n, 4). ``cxcywh`` is centre
and size.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tsr_engine.records import FloatArray

MIN_SIDE: Final = 4.0
"""px: detectors and searches leave out boxes with a shorter side."""


def to_cxcywh(boxes: ArrayLike) -> FloatArray:
    """Corners to centre and size; any shape (..., 4)."""
    b = np.asarray(boxes, dtype=np.float64)
    return np.stack(
        [(b[..., 0] + b[..., 2]) / 2, (b[..., 1] + b[..., 3]) / 2, b[..., 2] - b[..., 0], b[..., 3] - b[..., 1]],
        axis=-1,
    )


def to_xyxy(boxes: ArrayLike) -> FloatArray:
    """Centre and size to corners; any shape (..., 4)."""
    b = np.asarray(boxes, dtype=np.float64)
    half_w, half_h = b[..., 2] / 2, b[..., 3] / 2
    return np.stack([b[..., 0] - half_w, b[..., 1] - half_h, b[..., 0] + half_w, b[..., 1] + half_h], axis=-1)


def area(boxes: ArrayLike) -> FloatArray:
    """Area in px^2, zero for empty or inverted boxes; shape (...)."""
    b = np.asarray(boxes, dtype=np.float64)
    return np.asarray(np.maximum(0.0, b[..., 2] - b[..., 0]) * np.maximum(0.0, b[..., 3] - b[..., 1]))


def shorter_side(boxes: ArrayLike) -> FloatArray:
    """The lesser of width and height in px, not above 0 for boxes without area; shape (...)."""
    b = np.asarray(boxes, dtype=np.float64)
    return np.asarray(np.minimum(b[..., 2] - b[..., 0], b[..., 3] - b[..., 1]))


def intersection(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Pairwise intersection areas in px^2, shape (n, m)."""
    p = np.asarray(a, dtype=np.float64).reshape(-1, 1, 4)
    q = np.asarray(b, dtype=np.float64).reshape(1, -1, 4)
    return intersection_each(p, q)


def iou(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Pairwise intersection over union in [0, 1], shape (n, m)."""
    inter = intersection(a, b)
    union = np.reshape(area(a), (-1, 1)) + np.reshape(area(b), (1, -1)) - inter
    return np.asarray(np.divide(inter, union, out=np.zeros_like(inter), where=union > 0))


def intersection_each(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Intersection areas in px^2 of boxes at the same index in ``a`` and ``b``; shapes (..., 4) broadcast."""
    p, q = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    w = np.minimum(p[..., 2], q[..., 2]) - np.maximum(p[..., 0], q[..., 0])
    h = np.minimum(p[..., 3], q[..., 3]) - np.maximum(p[..., 1], q[..., 1])
    return np.asarray(np.maximum(0.0, w) * np.maximum(0.0, h))


def iou_each(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Intersection over union of boxes at the same index in ``a`` and ``b``, in [0, 1], shape (n,)."""
    p, q = np.asarray(a, dtype=np.float64).reshape(-1, 4), np.asarray(b, dtype=np.float64).reshape(-1, 4)
    inter = intersection_each(p, q)
    union = area(p) + area(q) - inter
    return np.asarray(np.divide(inter, union, out=np.zeros_like(inter), where=union > 0))


def covered_share(boxes: ArrayLike, regions: ArrayLike) -> FloatArray:
    """The largest share of each box that lies in one of the regions, in [0, 1], shape (n,); 0 without regions."""
    inter = intersection(boxes, regions)
    areas = np.reshape(area(boxes), (-1, 1))
    return np.asarray(np.divide(inter, areas, out=np.zeros_like(inter), where=areas > 0).max(axis=1, initial=0.0))


def non_overlap(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Localisation error of Eq. 7, ``1 - inter / max(area)``, in [0, 1], shape (n, m); 0 is perfect."""
    inter = intersection(a, b)
    larger = np.maximum(np.reshape(area(a), (-1, 1)), np.reshape(area(b), (1, -1)))
    return np.asarray(1.0 - np.divide(inter, larger, out=np.zeros_like(inter), where=larger > 0))


def non_overlap_each(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Localisation error of Eq. 7 of boxes at the same index in ``a`` and ``b``, in [0, 1], shape (n,)."""
    p, q = np.asarray(a, dtype=np.float64).reshape(-1, 4), np.asarray(b, dtype=np.float64).reshape(-1, 4)
    inter, larger = intersection_each(p, q), np.maximum(area(p), area(q))
    return np.asarray(1.0 - np.divide(inter, larger, out=np.zeros_like(inter), where=larger > 0))


def clip(boxes: ArrayLike, width: float, height: float) -> FloatArray:
    """Boxes clipped to a picture of width x height px; shape unchanged."""
    b = np.array(boxes, dtype=np.float64)
    b[..., 0::2] = b[..., 0::2].clip(0, width)
    b[..., 1::2] = b[..., 1::2].clip(0, height)
    return b


def expand(boxes: ArrayLike, share: float) -> FloatArray:
    """Boxes enlarged on each side by ``share`` of their width and height."""
    b = to_cxcywh(boxes)
    b[..., 2:] *= 1.0 + 2.0 * share
    return to_xyxy(b)
