"""Cuts a sign out of a picture with the border that the classifier expects."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike

from tsr_engine.protocols import PixelSource
from tsr_engine.records import Picture


def crop_bounds(box: ArrayLike, margin: float) -> tuple[int, int, int, int]:
    """Whole-pixel bounds of a box with a border.

    Args:
        box: shape (4,), ``x1, y1, x2, y2`` in px.
        margin: border on each side as a share of the box's own width and height, >= 0.

    Returns:
        ``x1, y1, x2, y2`` rounded to the nearest pixel edge, at least one pixel wide and high; may lie outside
        the picture.
    """
    x1, y1, x2, y2 = np.asarray(box, dtype=np.float64)
    dx, dy = margin * (x2 - x1), margin * (y2 - y1)
    left, top = int(np.floor(x1 - dx + 0.5)), int(np.floor(y1 - dy + 0.5))
    right, bottom = int(np.floor(x2 + dx + 0.5)), int(np.floor(y2 + dy + 0.5))
    return left, top, max(right, left + 1), max(bottom, top + 1)


def cut_pixels(pixels: PixelSource, box: ArrayLike, margin: float) -> Picture:
    """The pixels of a box and its border from a frame, as ``cut``; the box may lie outside the frame."""
    return pixels.crop(*crop_bounds(box, margin))


def cut(picture: Picture, box: ArrayLike, margin: float) -> Picture:
    """Cut out the pixels of a box and its border; the picture's border is replicated beyond its edges.

    Args:
        picture: BGR, uint8, shape (height, width, 3).
        box: shape (4,), ``x1, y1, x2, y2`` in px; must overlap the picture.
        margin: border on each side as a share of the box's side.

    Returns:
        A C-contiguous copy, shape (h, w, 3).

    Raises:
        ValueError: the box does not overlap the picture.
    """
    height, width = picture.shape[:2]
    x1, y1, x2, y2 = crop_bounds(box, margin)
    left, top, right, bottom = max(x1, 0), max(y1, 0), min(x2, width), min(y2, height)
    if left >= right or top >= bottom:
        raise ValueError(f"The box {np.asarray(box).tolist()} does not overlap the picture of {width}x{height} px.")
    inside = picture[top:bottom, left:right]
    if (left, top, right, bottom) == (x1, y1, x2, y2):
        return np.ascontiguousarray(inside)
    padded = cv2.copyMakeBorder(inside, top - y1, y2 - bottom, left - x1, x2 - right, cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(padded, dtype=np.uint8)
