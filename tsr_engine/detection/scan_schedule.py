"""Spreads a scan over several frames of a video: the scales and rows to search in each frame.

The scales of the smallest signs take two thirds of a scan's time at any picture size. They are searched in strips, one
in each frame, and all larger scales together in another frame. The schedule depends only on the frame's number, so a
run gives the same result on any number of cores, and after a resume.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor

from tsr_engine.channels.pyramid import Band


def bands_of_frame(
    bands: Sequence[Band], smallest: Sequence[int], reach: Sequence[float], frame: int, turns: int
) -> list[Band | None]:
    """The bands of rows to search in one frame.

    Args:
        bands: bands of a whole scan, one for each scale, px.
        smallest: indices of the scales of the smallest signs.
        reach: overlap of strips, one for each scale, px: a sign on the border of two strips lies wholly in both.
        frame: number of the frame, >= 0.
        turns: number of frames that cover all bands once, >= 2.

    Returns:
        A band for each scale; None for a scale without a search in this frame.
    """
    turn = frame % turns
    if turn == turns - 1:
        return [None if i in smallest else band for i, band in enumerate(bands)]
    strips = turns - 1
    chosen: list[Band | None] = [None] * len(bands)
    for i in smallest:
        low, high = bands[i]
        strip_height = (high - low) / strips
        chosen[i] = (
            max(low, low + turn * strip_height - reach[i]),
            min(high, low + (turn + 1) * strip_height + reach[i]),
        )
    return chosen


def rows_of(bands: Sequence[Band | None], height: int) -> tuple[int, int]:
    """First and last + 1 picture row of the bands, within 0 to ``height``; (0, height) without bands."""
    searched = [band for band in bands if band is not None]
    if not searched:
        return 0, height
    return max(0, floor(min(b[0] for b in searched))), min(height, ceil(max(b[1] for b in searched)))
