"""Finds the fewest frames of a track between which straight lines stay close to its boxes; compiled."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def fewest_key_frames(
    frames: NDArray[np.int64], boxes: NDArray[np.float64], forced: NDArray[np.bool_], tolerance_px: float, span: int
) -> NDArray[np.bool_]:
    """Find the shortest path over the frames; an edge leads to each later frame that a straight line may reach.

    From each start, a cone of slopes narrows with every frame passed; a frame inside the cone can be the next key
    frame. No line passes over a forced frame.

    Args:
        frames: strictly ascending, shape (n,), n >= 1.
        boxes: shape (n, 4), px.
        forced: frames to keep, including the first and the last, shape (n,).
        tolerance_px: largest distance of an edge from the line, px, > 0.
        span: largest distance between two kept frames.

    Returns:
        Shape (n,), True for each kept frame.
    """
    n = len(frames)
    steps = np.full(n, n + 1, np.int64)
    previous = np.full(n, -1, np.int64)
    steps[0] = 0
    low = np.empty(4)
    high = np.empty(4)
    for start in range(n - 1):
        low[:] = -np.inf
        high[:] = np.inf
        for end in range(start + 1, min(n, start + span + 1)):
            gap = float(frames[end] - frames[start])
            inside = True
            for edge in range(4):
                slope = (boxes[end, edge] - boxes[start, edge]) / gap
                if slope < low[edge] or slope > high[edge]:
                    inside = False
            if inside and steps[start] + 1 < steps[end]:
                steps[end] = steps[start] + 1
                previous[end] = start
            if forced[end]:
                break
            empty = False
            for edge in range(4):
                rise = boxes[end, edge] - boxes[start, edge]
                low[edge] = max(low[edge], (rise - tolerance_px) / gap)
                high[edge] = min(high[edge], (rise + tolerance_px) / gap)
                if low[edge] > high[edge]:
                    empty = True
            if empty:
                break
    keep = np.zeros(n, np.bool_)
    current = n - 1
    while current >= 0:
        keep[current] = True
        current = previous[current]
    return keep
