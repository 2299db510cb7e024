"""Spreads a scan over several frames of a video: the scales and rows to search in each frame.

The scales of the smallest signs take two thirds of a scan's time at any picture size. They are searched in strips, one
in each frame, and all larger scales together in another frame. The schedule depends on the frame's number alone: a run
gives the same result on any number of cores, and after a resume.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor

from tsr_engine.channels.pyramid import Band

__all__ = ["bands_in_turn", "rows_of"]


def bands_in_turn(
    bands: Sequence[Band], smallest: Sequence[int], reach: Sequence[float], frame: int, turns: int
) -> list[Band | None]:
    """The bands of rows that are searched in one frame.

    Args:
        bands: of each scale, px, as for a whole scan.
        smallest: indices of the scales of the smallest signs.
        reach: of each scale, px: how far strips overlap, so that a sign on the border of two lies wholly in each.
        frame: number of the frame, >= 0.
        turns: frames in which everything is searched once, >= 2.

    Returns:
        A band for each scale; None for a scale that is not searched in this frame.
    """
    turn = frame % turns
    if turn == turns - 1:
        return [None if i in smallest else band for i, band in enumerate(bands)]
    strips = turns - 1
    found: list[Band | None] = [None] * len(bands)
    for i in smallest:
        low, high = bands[i]
        tall = (high - low) / strips
        found[i] = (max(low, low + turn * tall - reach[i]), min(high, low + (turn + 1) * tall + reach[i]))
    return found


def rows_of(bands: Sequence[Band | None], height: int) -> tuple[int, int]:
    """First and last + 1 picture row that bands need; (0, height) if there is none."""
    searched = [band for band in bands if band is not None]
    if not searched:
        return 0, height
    return max(0, floor(min(b[0] for b in searched))), min(height, ceil(max(b[1] for b in searched)))
