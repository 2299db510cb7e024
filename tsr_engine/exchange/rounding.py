"""Rounds coordinates so that they stay boxes inside of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["rounded", "whole_pixels"]


def rounded(boxes: NDArray[np.float64], decimals: int, width: int, height: int) -> NDArray[np.float64]:
    """Boxes rounded to decimals, never without area and never outside of the picture.

    Args:
        boxes: shape (n, 4), px edges, inside of the picture.
        decimals: of the result.
        width: of the picture, px.
        height: px.

    Returns:
        shape (n, 4); a side that would vanish gets the smallest length that shows.
    """
    out = np.round(boxes, decimals)
    least = 10.0**-decimals
    for low, limit in ((0, width), (1, height)):
        thin = out[:, low] >= out[:, low + 2]
        if thin.any():
            out[thin, low] = np.minimum(out[thin, low], limit - least)
            out[thin, low + 2] = out[thin, low] + least
    return np.round(out, decimals)


def whole_pixels(boxes: NDArray[np.float64], width: int, height: int) -> NDArray[np.int64]:
    """Boxes with whole edges, each at least one pixel wide and high and inside of the picture.

    Args:
        boxes: shape (n, 4), px edges.
        width: of the picture, px.
        height: px.

    Returns:
        shape (n, 4); halves are rounded up.
    """
    out = np.floor(boxes + 0.5).astype(np.int64)
    for low, limit in ((0, width), (1, height)):
        out[:, low] = np.clip(out[:, low], 0, limit - 1)
        out[:, low + 2] = np.clip(out[:, low + 2], out[:, low] + 1, limit)
    return out
