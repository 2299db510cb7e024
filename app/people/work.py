"""Figures of people's work. Nothing here reads a database."""

from __future__ import annotations

import math

__all__ = ["share_interval"]


def share_interval(count: int, of: int) -> tuple[float, float]:
    """The 95 % interval of a share that was counted (Wilson 1927); 0 to 1 where nothing was."""
    if of == 0:
        return 0.0, 1.0
    z, share = 1.959964, count / of
    middle = (share + z * z / (2 * of)) / (1 + z * z / of)
    half = z * math.sqrt(share * (1 - share) / of + z * z / (4 * of * of)) / (1 + z * z / of)
    return max(0.0, middle - half), min(1.0, middle + half)
