"""Square patches around boxes, resampled so that the sign has a fixed size."""

from __future__ import annotations

from math import sqrt

import cv2
import numpy as np

from tsr_engine.detection.resample import area_means, sample, span
from tsr_engine.records import FloatArray, Picture

_AREA_SCALE = 0.95
"""Scale below which pixels are averaged over their areas first, since bilinear sampling alone would alias."""


def cut_patch(
    picture: Picture, box: FloatArray, sign: float, side: int, distortion: FloatArray | None = None
) -> Picture:
    """Cut a patch of ``side`` px with the box in its middle.

    Args:
        picture: BGR uint8.
        box: shape (4,), corners in px; may reach beyond the picture, whose border is replicated.
        sign: length in the patch of the box's mean side (root of its area), px.
        side: side of the patch, px.
        distortion: shape (2, 2): linear map about the box's centre, from (x, y) of the scaled picture to (x, y) of the
            patch. Unset: none.

    Returns:
        BGR uint8, shape (side, side, 3).
    """
    x1, y1, x2, y2 = (float(value) for value in box)  # Python's floats are faster than NumPy's scalars
    cx, cy = (x1 + x2) / 2, (y1 + y2) / 2
    scale = sign / sqrt(max(1.0, (x2 - x1) * (y2 - y1)))
    if distortion is None:
        return _stretched(picture, cx, cy, scale, 1.0, 1.0, side)
    (across, slant), (turn, down) = distortion.tolist()
    if slant or turn:
        return _distorted(picture, cx, cy, scale, side, distortion)
    return _stretched(picture, cx, cy, scale, across, down, side)


def _stretched(picture: Picture, cx: float, cy: float, scale: float, across: float, down: float, side: int) -> Picture:
    """A patch around (cx, cy), scaled and stretched along the axes: the bits of OpenCV's functions, but for ties."""
    out = np.empty((side, side, 3), np.uint8)
    rows = np.ascontiguousarray(picture).reshape(len(picture), -1)
    if scale < _AREA_SCALE:
        rows, cx, cy = area_means(rows, cx, cy, scale, side, 0.5 * side / min(across, down))
        scale = 1.0
    sample(rows, cx, cy, scale * across, scale * down, out)
    return out


def _distorted(picture: Picture, cx: float, cy: float, scale: float, side: int, distortion: FloatArray) -> Picture:
    """A patch around (cx, cy), scaled and distorted."""
    if scale < _AREA_SCALE:
        margin = 0.75 * side / scale
        height, width = picture.shape[:2]
        left, right = span(cx, margin, width)
        top, bottom = span(cy, margin, height)
        size = (max(1, round((right - left) * scale)), max(1, round((bottom - top) * scale)))
        region = cv2.resize(picture[top:bottom, left:right], size, interpolation=cv2.INTER_AREA)
        picture = np.asarray(region, dtype=np.uint8)
        cx, cy = (cx - left) * size[0] / (right - left), (cy - top) * size[1] / (bottom - top)
        scale = 1.0
    # OpenCV's coordinates are of pixel centres, a box's of pixel edges: half a pixel on both sides of the map.
    linear = scale * distortion
    shift = side / 2 - (linear[:, 0] * cx + linear[:, 1] * cy) + 0.5 * (linear.sum(axis=1) - 1)
    matrix = np.column_stack([linear, shift])
    patch = cv2.warpAffine(picture, matrix, (side, side), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(patch, dtype=np.uint8)
