"""Smooths byte channels by [1 2 1]/4 along both axes, to remove the grid's jitter before the trees read the cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tsr_engine.kernels import kernel
from tsr_engine.row_copy import copy_row


def smooth(cells: NDArray[np.uint8], border: int = 0, out: NDArray[np.uint8] | None = None) -> NDArray[np.uint8]:
    """Smooth channels by [1 2 1]/4 along both axes, halves rounded up, borders replicated.

    Args:
        cells: shape (channels, h, w), uint8.
        border: replicated cells around the result.
        out: array for the result; unset: a new one.

    Returns:
        Shape (channels, h + 2 border, w + 2 border), uint8.
    """
    channels, h, w = cells.shape
    if out is None:
        out = np.empty((channels, h + 2 * border, w + 2 * border), np.uint8)
    _smooth(cells, border, np.empty(w + 2, np.uint16), out)
    return out


@kernel()
def replicate(cells, border):  # type: ignore[no-untyped-def]
    """Fills ``border`` cells on each side of (channels, rows, columns) with the nearest inner cell, in place."""
    channels, rows, columns = cells.shape
    for c in range(channels):
        for y in range(border, rows - border):
            row = cells[c, y]
            for x in range(border):
                row[x] = row[border]
                row[columns - 1 - x] = row[columns - 1 - border]
        for y in range(border):
            copy_row(cells[c, border], cells[c, y])
            copy_row(cells[c, rows - 1 - border], cells[c, rows - 1 - y])


@kernel()
def _smooth_down(above, here, below, out):  # type: ignore[no-untyped-def]
    """Adds three rows (w,) of bytes with weights [1 2 1], to sums of at most 1020."""
    for x in range(out.shape[0]):
        out[x] = np.uint16(above[x]) + np.uint16(2) * np.uint16(here[x]) + np.uint16(below[x])


@kernel()
def _smooth_across(padded, out):  # type: ignore[no-untyped-def]
    """Filters a row of sums (w + 2,) by [1 2 1]/16, to bytes (w,)."""
    left, here, right = padded[:-2], padded[1:-1], padded[2:]
    for x in range(out.shape[0]):
        # Without a cast before the shift, Numba computes in 64 bits.
        out[x] = np.uint16(left[x] + np.uint16(2) * here[x] + right[x] + np.uint16(8)) >> np.uint16(4)


@kernel()
def _smooth(cells, border, sums, out):  # type: ignore[no-untyped-def]
    channels, h, w = cells.shape
    for c in range(channels):
        for y in range(h):
            _smooth_down(cells[c, max(y - 1, 0)], cells[c, y], cells[c, min(y + 1, h - 1)], sums[1 : w + 1])
            sums[0], sums[w + 1] = sums[1], sums[w]
            _smooth_across(sums, out[c, y + border, border : border + w])
    replicate(out, border)
