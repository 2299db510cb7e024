"""The channels' sums over cells of 2x2 px, without rows of pixels in between.

Rows of pixels are kept as even and odd columns. All four pixels of a cell then lie at the same place of some row, so
that a cell is summed in registers: the general way (:mod:`tsr_engine.channels.compute`) writes and reads each pixel's
ten values once more. Strips of columns keep the rows in the first-level cache.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import FASTMATH_FLAGS, gradient_orientations, luv
from tsr_engine.kernels import kernel

__all__ = ["MARGIN_CELLS", "SPAN", "STRIP_CELLS", "begin_strip", "compute_cell_row", "make_buffers"]

STRIP_CELLS: Final = 304
"""Largest number of cells of a strip."""
MARGIN_CELLS: Final = 4
"""Cells beyond a strip on each side that its filters reach: two px here, and the normalising filter."""
SPAN: Final = STRIP_CELLS + 2 * MARGIN_CELLS + 8
"""Values of a channel in a row of cells, and of a colour in a row of even or odd columns."""
# A row is one array of L, U and V of the even columns, then of the odd ones, SPAN values each. Distances that the
# compiler knows save it from checking at run time whether rows overlap. Odd columns lie one place further right, so
# that even column k lies between the odd columns k and k + 1.
_ODD: Final = 3 * SPAN
_E1: Final = SPAN
_E2: Final = 2 * SPAN
_O1: Final = 4 * SPAN
_O2: Final = 5 * SPAN


@kernel(fastmath=FASTMATH_FLAGS)
def _luv_row(blue, green, red, row):  # type: ignore[no-untyped-def]
    """Converts three uint8 rows (w,) to a row, borders replicated."""
    w = blue.shape[0]
    n = w // 2
    for k in range(n):
        row[k], row[_E1 + k], row[_E2 + k] = luv(blue[2 * k], green[2 * k], red[2 * k])
        row[_ODD + 1 + k], row[_O1 + 1 + k], row[_O2 + 1 + k] = luv(blue[2 * k + 1], green[2 * k + 1], red[2 * k + 1])
    for c in range(3):
        even, odd = c * SPAN, _ODD + c * SPAN
        row[odd] = row[even]
        row[even + n] = row[odd + n]
    if w % 2:
        row[n], row[_E1 + n], row[_E2 + n] = luv(blue[w - 1], green[w - 1], red[w - 1])


@kernel(fastmath=FASTMATH_FLAGS)
def _smooth_row(above, here, below, w, column, out):  # type: ignore[no-untyped-def]
    """Smooths rows of w px by [1 2 1]/4 along both axes, borders replicated; ``column`` is working memory."""
    n = w // 2
    for c in range(3):
        even, odd = c * SPAN, _ODD + c * SPAN
        for first in (even, odd):
            for k in range(first, first + n + 1):
                column[k] = np.float32(0.0625) * (above[k] + below[k]) + np.float32(0.125) * here[k]
        for k in range(n):
            out[even + k] = column[odd + k] + np.float32(2.0) * column[even + k] + column[odd + 1 + k]
            out[odd + 1 + k] = column[even + k] + np.float32(2.0) * column[odd + 1 + k] + column[even + 1 + k]
        out[odd] = out[even]
        out[even + n] = column[odd + n] + np.float32(3.0) * column[even + n] if w % 2 else out[odd + n]


@kernel(fastmath=FASTMATH_FLAGS)
def _gradient_cells(r0, r1, r2, r3, n, out):  # type: ignore[no-untyped-def]
    """Sums of magnitude and orientations over n cells, whose pixels lie in the smoothed rows r1 and r2."""
    half = np.float32(0.125)  # the differences span two pixels
    for k in range(n):
        a = gradient_orientations(
            r1[_ODD + k + 1] - r1[_ODD + k], r2[k] - r0[k],
            r1[_O1 + k + 1] - r1[_O1 + k], r2[_E1 + k] - r0[_E1 + k],
            r1[_O2 + k + 1] - r1[_O2 + k], r2[_E2 + k] - r0[_E2 + k],
        )  # fmt: skip
        b = gradient_orientations(
            r2[_ODD + k + 1] - r2[_ODD + k], r3[k] - r1[k],
            r2[_O1 + k + 1] - r2[_O1 + k], r3[_E1 + k] - r1[_E1 + k],
            r2[_O2 + k + 1] - r2[_O2 + k], r3[_E2 + k] - r1[_E2 + k],
        )  # fmt: skip
        c = gradient_orientations(
            r1[k + 1] - r1[k], r2[_ODD + k + 1] - r0[_ODD + k + 1],
            r1[_E1 + k + 1] - r1[_E1 + k], r2[_O1 + k + 1] - r0[_O1 + k + 1],
            r1[_E2 + k + 1] - r1[_E2 + k], r2[_O2 + k + 1] - r0[_O2 + k + 1],
        )  # fmt: skip
        d = gradient_orientations(
            r2[k + 1] - r2[k], r3[_ODD + k + 1] - r1[_ODD + k + 1],
            r2[_E1 + k + 1] - r2[_E1 + k], r3[_O1 + k + 1] - r1[_O1 + k + 1],
            r2[_E2 + k + 1] - r2[_E2 + k], r3[_O2 + k + 1] - r1[_O2 + k + 1],
        )  # fmt: skip
        out[3 * SPAN + k] = ((a[0] + b[0]) + (c[0] + d[0])) * half
        out[4 * SPAN + k] = ((a[1] + b[1]) + (c[1] + d[1])) * half
        out[5 * SPAN + k] = ((a[2] + b[2]) + (c[2] + d[2])) * half
        out[6 * SPAN + k] = ((a[3] + b[3]) + (c[3] + d[3])) * half
        out[7 * SPAN + k] = ((a[4] + b[4]) + (c[4] + d[4])) * half
        out[8 * SPAN + k] = ((a[5] + b[5]) + (c[5] + d[5])) * half
        out[9 * SPAN + k] = ((a[6] + b[6]) + (c[6] + d[6])) * half


@kernel(fastmath=FASTMATH_FLAGS)
def _colour_cells(r1, r2, n, out):  # type: ignore[no-untyped-def]
    """Means of the smoothed colours over n cells."""
    for c in range(3):
        even, odd = c * SPAN, _ODD + c * SPAN + 1
        for k in range(n):
            out[even + k] = ((r1[even + k] + r2[even + k]) + (r1[odd + k] + r2[odd + k])) * np.float32(0.25)


def make_buffers() -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Working memory for a strip: three rows of LUV, four of smoothed LUV, a scratch row."""
    return np.empty((3, 6 * SPAN), np.float32), np.empty((4, 6 * SPAN), np.float32), np.empty(6 * SPAN, np.float32)


@kernel(fastmath=FASTMATH_FLAGS)
def begin_strip(blue, green, red, left, right, buffers):  # type: ignore[no-untyped-def]
    """Fills the rows of the buffers that :func:`compute_cell_row` needs for the first row of cells."""
    raw, smooth, column = buffers
    h, w = blue.shape[0], right - left
    for y in range(min(2, h)):
        _luv_row(blue[y, left:right], green[y, left:right], red[y, left:right], raw[y])
    _smooth_row(raw[0], raw[0], raw[min(1, h - 1)], w, column, smooth[0])


@kernel(fastmath=FASTMATH_FLAGS)
def compute_cell_row(blue, green, red, left, right, row, buffers, cells):  # type: ignore[no-untyped-def]
    """One row of cells of planes (h, w); call it row by row, in order, after :func:`begin_strip`.

    The cells are those of the pixels from ``left`` to ``right``, at most ``2 * (STRIP + 2 * MARGIN) + 1``. Those of
    channel c begin at ``c * SPAN`` of ``cells``.
    """
    raw, smooth, column = buffers
    h, w = blue.shape[0], right - left
    n = w // 2
    for y in range(2 * row + 1, min(2 * row + 3, h)):
        if y + 1 < h:
            below = y + 1
            _luv_row(blue[below, left:right], green[below, left:right], red[below, left:right], raw[below % 3])
        _smooth_row(raw[(y - 1) % 3], raw[y % 3], raw[min(y + 1, h - 1) % 3], w, column, smooth[y % 4])
    r0, r1 = smooth[max(2 * row - 1, 0) % 4], smooth[2 * row % 4]
    r2, r3 = smooth[(2 * row + 1) % 4], smooth[min(2 * row + 2, h - 1) % 4]
    _gradient_cells(r0, r1, r2, r3, n, cells)
    _colour_cells(r1, r2, n, cells)
