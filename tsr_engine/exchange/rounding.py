"""Rounds coordinates so that boxes keep an area and stay inside the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def round_boxes(boxes: NDArray[np.float64], decimals: int, width: int, height: int) -> NDArray[np.float64]:
    """Round boxes to a number of decimals; none loses its area or leaves the picture.

    Args:
        boxes: shape (n, 4), px edges, inside the picture.
        decimals: of the result.
        width: picture width, px.
        height: picture height, px.

    Returns:
        Shape (n, 4), px; a side that would vanish gets the smallest visible length.
    """
    out = np.round(boxes, decimals)
    min_side = 10.0**-decimals
    for low, limit in ((0, width), (1, height)):
        is_empty = out[:, low] >= out[:, low + 2]
        if is_empty.any():
            out[is_empty, low] = np.minimum(out[is_empty, low], limit - min_side)
            out[is_empty, low + 2] = out[is_empty, low] + min_side
    return np.round(out, decimals)


def round_to_sizes(boxes: NDArray[np.float64], decimals: int, width: int, height: int) -> list[list[float]]:
    """As ``round_boxes``, but ``x, y, width, height`` of each box, as a list."""
    out = round_boxes(boxes, decimals, width, height)
    out[:, 2:] = np.round(out[:, 2:] - out[:, :2], decimals)
    sizes: list[list[float]] = out.tolist()
    return sizes


def round_to_pixels(boxes: NDArray[np.float64], width: int, height: int) -> NDArray[np.int64]:
    """Round boxes to whole edges; each is at least one pixel wide and high and inside the picture.

    Args:
        boxes: shape (n, 4), px edges.
        width: picture width, px.
        height: picture height, px.

    Returns:
        Shape (n, 4), px; halves are rounded up.
    """
    out = np.floor(boxes + 0.5).astype(np.int64)
    for low, limit in ((0, width), (1, height)):
        out[:, low] = np.clip(out[:, low], 0, limit - 1)
        out[:, low + 2] = np.clip(out[:, low + 2], out[:, low] + 1, limit)
    return out
