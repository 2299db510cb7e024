"""Finds the fewest frames of a track between which straight lines stay close to its boxes; compiled."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["fewest_key_frames"]


@njit(cache=True, nogil=True)
def fewest_key_frames(
    frames: NDArray[np.int64], boxes: NDArray[np.float64], forced: NDArray[np.bool_], allowed: float, span: int
) -> NDArray[np.bool_]:
    """Find the shortest path over the frames; an edge leads to each later frame that a straight line may reach.

    From each start, a cone of slopes narrows with every frame passed; a frame inside the cone can be the next key
    frame. No line passes over a forced frame.

    Args:
        frames: strictly ascending, shape (n,), n >= 1.
        boxes: shape (n, 4), px.
        forced: frames to keep, including the first and the last, shape (n,).
        allowed: largest distance of an edge from the line, px, > 0.
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
    for a in range(n - 1):
        low[:] = -np.inf
        high[:] = np.inf
        for b in range(a + 1, min(n, a + span + 1)):
            gap = float(frames[b] - frames[a])
            inside = True
            for edge in range(4):
                slope = (boxes[b, edge] - boxes[a, edge]) / gap
                if slope < low[edge] or slope > high[edge]:
                    inside = False
            if inside and steps[a] + 1 < steps[b]:
                steps[b] = steps[a] + 1
                previous[b] = a
            if forced[b]:
                break
            empty = False
            for edge in range(4):
                rise = boxes[b, edge] - boxes[a, edge]
                low[edge] = max(low[edge], (rise - allowed) / gap)
                high[edge] = min(high[edge], (rise + allowed) / gap)
                if low[edge] > high[edge]:
                    empty = True
            if empty:
                break
    keep = np.zeros(n, np.bool_)
    at = n - 1
    while at >= 0:
        keep[at] = True
        at = previous[at]
    return keep
