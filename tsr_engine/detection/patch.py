"""Square patches around boxes, resampled so that the sign has a fixed size."""

from __future__ import annotations

from math import sqrt

import cv2
import numpy as np

from tsr_engine.records import FloatArray, Picture


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
    if scale < 0.95:  # an area filter first, since bilinear sampling alone would alias
        margin = 0.75 * side / scale
        height, width = picture.shape[:2]
        left, right = _span(cx, margin, width)
        top, bottom = _span(cy, margin, height)
        region = picture[top:bottom, left:right]
        size = (max(1, round((right - left) * scale)), max(1, round((bottom - top) * scale)))
        picture = np.asarray(cv2.resize(region, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        cx, cy = (cx - left) * size[0] / (right - left), (cy - top) * size[1] / (bottom - top)
        scale = 1.0
    # OpenCV's coordinates are of pixel centres, a box's of pixel edges: half a pixel on both sides of the map.
    if distortion is None:
        beyond = 0.5 * (scale - 1)
        matrix = np.array([[scale, 0.0, side / 2 - scale * cx + beyond], [0.0, scale, side / 2 - scale * cy + beyond]])
    else:
        linear = scale * distortion
        shift = side / 2 - (linear[:, 0] * cx + linear[:, 1] * cy) + 0.5 * (linear.sum(axis=1) - 1)
        matrix = np.column_stack([linear, shift])
    patch = cv2.warpAffine(picture, matrix, (side, side), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(patch, dtype=np.uint8)


def _span(centre: float, margin: float, size: int) -> tuple[int, int]:
    """Whole pixels of ``[centre - margin, centre + margin]`` inside ``[0, size]``, at least one."""
    low = int(min(max(0.0, centre - margin), size - 1))
    high = int(max(min(size, centre + margin), low + 1))
    return low, high
