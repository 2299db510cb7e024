"""Moves the sides of a rough box to the edges of the sign."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from tsr_engine.records import FloatArray, Picture

MAX_MOVE_SHARE: Final = 0.10
"""Largest move of a side, as a share of the box's width or height; at least two px."""
TRUST: Final = 0.05
"""Standard deviation of a rough side's error, share of the width or height; more distant edges must be stronger."""
STEPS: Final = 4
"""Number of tried places per px."""
RECTANGLE, ROUND = 0.7, 0.3
"""Share of a side, in its middle, along which the sign's edge lies on it."""


def fit_box(picture: Picture, box: FloatArray, *, round_sign: bool) -> FloatArray:
    """Move a box's sides to the strongest edges nearby.

    Args:
        picture: BGR, uint8.
        box: shape (4,), ``x1, y1, x2, y2``, px.
        round_sign: whether the sign touches only the middles of the box's sides.

    Returns:
        Shape (4,), px, within the picture.
    """
    height, width = picture.shape[:2]
    smooth = cv2.GaussianBlur(picture, (0, 0), 0.8).astype(np.float32)
    fitted = np.array(box, dtype=np.float64)
    middle = ROUND if round_sign else RECTANGLE
    for axis in (0, 1):
        length = float(box[axis + 2] - box[axis])
        across = 1 - axis
        centre, half = (box[across] + box[across + 2]) / 2, middle * (box[across + 2] - box[across]) / 2
        along = np.arange(max(centre - half, 0), min(centre + half, (height, width)[axis] - 1), 0.5)
        for side in (axis, axis + 2):
            reach = max(MAX_MOVE_SHARE * length, 2.0)
            places = box[side] + np.arange(-reach, reach + 1e-6, 1 / STEPS)
            inside = (places >= 1) & (places <= (width, height)[axis] - 1)
            places = places[inside]
            if not len(places) or not len(along):
                continue
            strength = _edge(smooth, places, along, axis)
            distance = (places - box[side]) / max(TRUST * length, 1.0)
            fitted[side] = places[np.argmax(strength * np.exp(-0.5 * distance**2))]
    fitted[[0, 2]] = np.clip(fitted[[0, 2]], 0, width)
    fitted[[1, 3]] = np.clip(fitted[[1, 3]], 0, height)
    return fitted


def _edge(smooth: np.ndarray, places: FloatArray, along: FloatArray, axis: int) -> FloatArray:
    """Mean colour change across each place (in pixel edges), along ``along``, summed over the channels."""
    across, line = np.meshgrid(places, along)
    sampled = []
    for offset in (-1.0, 1.0):
        at_x, at_y = (across + offset - 0.5, line - 0.5) if axis == 0 else (line - 0.5, across + offset - 0.5)
        maps = at_x.astype(np.float32), at_y.astype(np.float32)
        sampled.append(cv2.remap(smooth, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
    return np.asarray(np.abs((sampled[1] - sampled[0]).mean(axis=0)).sum(axis=-1) + 1e-6, np.float64)
