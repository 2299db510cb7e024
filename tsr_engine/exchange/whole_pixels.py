"""Boxes for formats that know whole pixels only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["whole_pixels"]


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
