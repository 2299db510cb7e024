"""Square patches around boxes, resampled so that the sign has a fixed size."""

from __future__ import annotations

from math import sqrt

import cv2
import numpy as np

from tsr_engine.records import FloatArray, Picture


def cut_patch(
    picture: Picture, box: FloatArray, sign: float, side: int, distortion: FloatArray | None = None
) -> Picture:
    """A patch of ``side`` px with the box in its middle.

    Args:
        picture: BGR uint8.
        box: shape (4,), corners in px; may reach beyond the picture, whose border is replicated.
        sign: px that the box's mean side (root of its area) has in the patch.
        side: side of the patch, px.
        distortion: shape (2, 2): turns and stretches what is seen about the box's centre, (x, y) of the scaled picture
            to (x, y) of the patch. Unset: as it is.

    Returns:
        BGR uint8, shape (side, side, 3).
    """
    x1, y1, x2, y2 = (float(value) for value in box)  # numbers of Python: a patch is a few dozen steps with them
    cx, cy = (x1 + x2) / 2, (y1 + y2) / 2
    scale = sign / sqrt(max(1.0, (x2 - x1) * (y2 - y1)))
    if scale < 0.95:  # shrink with an area filter first: bilinear sampling alone would alias
        margin = 0.75 * side / scale
        height, width = picture.shape[:2]
        left, right = _span(cx, margin, width)
        top, bottom = _span(cy, margin, height)
        region = picture[top:bottom, left:right]
        size = (max(1, round((right - left) * scale)), max(1, round((bottom - top) * scale)))
        picture = np.asarray(cv2.resize(region, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        cx, cy = (cx - left) * size[0] / (right - left), (cy - top) * size[1] / (bottom - top)
        scale = 1.0
    # OpenCV counts pixel centres, boxes count edges: half a pixel on either side of the map
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
