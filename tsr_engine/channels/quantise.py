"""Channels as bytes, the input of the trees.

Eight bits a channel are enough for thresholds. They quarter the memory traffic, and one vector instruction compares
dozens of windows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.column_pairs import (
    MARGIN_CELLS,
    SPAN,
    STRIP_CELLS,
    begin_strip,
    compute_cell_row,
    make_buffers,
)
from tsr_engine.channels.compute import (
    CHANNELS,
    FASTMATH_FLAGS,
    NORM_CONST,
    check_picture,
    norm_radius,
    plane_channels,
    triangle,
)
from tsr_engine.kernels import kernel
from tsr_engine.records import Picture
from tsr_engine.row_copy import copy_row

OFFSET: Final = (0.0, 0.15, 0.15, *([0.0] * 7))
"""Channel value that becomes 0; lower values are clipped."""
GAIN: Final = (680.0, 425.0, 425.0, *([120.0] * 7))
"""Bytes per unit: L reaches 255 at 0.375, U and V at 0.75, gradients at 2.1 times the local mean."""

_OFFSET = np.array(OFFSET, np.float32)
_GAIN = np.array(GAIN, np.float32)
_OFFSET.flags.writeable = False
_GAIN.flags.writeable = False


def quantise(channels: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Channels of :func:`tsr_engine.channels.compute.compute_channels` as bytes, same shape, rounded and clipped."""
    out = np.empty(channels.shape, np.uint8)
    _quantise(channels, out, _OFFSET, _GAIN)
    return out


def channel_bytes(picture: Picture, shrink: int = 2) -> NDArray[np.uint8]:
    """``quantise(compute_channels(picture, shrink))``; values differ by at most 1.

    Cells of 2 px take one pass: only the rows of cells that the normalising filter spans are in memory as floats; each
    is normalised and written as bytes. This saves most of the memory traffic, which costs as much as the arithmetic.

    Args:
        picture: BGR, uint8, shape (h, w, 3), at least ``shrink`` px on each side.
        shrink: cell size in px.

    Returns:
        Shape (10, h // shrink, w // shrink), uint8.

    Raises:
        ValueError: the picture is not BGR uint8, or is smaller than one cell.
    """
    check_picture(picture, shrink)
    return plane_bytes(cv2.split(picture), shrink)


def plane_bytes(
    planes: Sequence[NDArray[np.uint8]] | NDArray[np.uint8], shrink: int = 2, out: NDArray[np.uint8] | None = None
) -> NDArray[np.uint8]:
    """:func:`channel_bytes` of a picture that is given as planes.

    Args:
        planes: blue, green and red, uint8, shape (h, w) each, at least ``shrink`` px on each side; rows contiguous.
        shrink: cell size in px.
        out: array for the result; unset: a new one.

    Returns:
        Shape (10, h // shrink, w // shrink), uint8.
    """
    blue, green, red = planes
    if out is None:
        out = np.empty((CHANNELS, blue.shape[0] // shrink, blue.shape[1] // shrink), np.uint8)
    if shrink != 2:
        _quantise(plane_channels(planes, shrink), out, _OFFSET, _GAIN)
        return out
    taps = triangle(norm_radius(shrink))
    cells, blurred = np.empty((len(taps), CHANNELS * SPAN), np.float32), np.empty((len(taps), SPAN), np.float32)
    buffers = (make_buffers(), cells, blurred, np.empty(SPAN, np.float32), np.empty(SPAN, np.float32))
    for start in range(0, out.shape[2], STRIP_CELLS):
        stop = min(start + STRIP_CELLS, out.shape[2])
        _quantise_strip(blue, green, red, start, stop, taps, np.float32(NORM_CONST), _OFFSET, _GAIN, buffers, out)
    return out


@kernel(fastmath=FASTMATH_FLAGS)
def _quantise_row(source, offset, gain, target):  # type: ignore[no-untyped-def]
    for x in range(source.shape[0]):
        value = (source[x] - offset) * gain + np.float32(0.5)
        value = min(max(value, np.float32(0.0)), np.float32(255.0))
        target[x] = np.uint8(np.int32(value))


@kernel(fastmath=FASTMATH_FLAGS)
def _scaled_row(source, factor, target):  # type: ignore[no-untyped-def]
    for x in range(source.shape[0]):
        value = min(source[x] * factor[x] + np.float32(0.5), np.float32(255.0))
        target[x] = np.uint8(np.int32(value))


@kernel()
def _quantise(channels, out, offset, gain):  # type: ignore[no-untyped-def]
    for c in range(channels.shape[0]):
        for y in range(channels.shape[1]):
            _quantise_row(channels[c, y], offset[c], gain[c], out[c, y])


@kernel(fastmath=FASTMATH_FLAGS)
def _blur_row(source, taps, padded, target):  # type: ignore[no-untyped-def]
    """Filters a row (n,) with five taps, borders replicated; ``padded`` is working memory of at least (n + 4,)."""
    n = source.shape[0]
    copy_row(source, padded[2 : n + 2])
    padded[0] = padded[1] = source[0]
    padded[n + 2] = padded[n + 3] = source[n - 1]
    t0, t1, t2, t3, t4 = taps[0], taps[1], taps[2], taps[3], taps[4]
    for x in range(n):
        target[x] = t0 * padded[x] + t1 * padded[x + 1] + t2 * padded[x + 2] + t3 * padded[x + 3] + t4 * padded[x + 4]


@kernel(fastmath=FASTMATH_FLAGS)
def _factors(r0, r1, r2, r3, r4, taps, const, gain, target):  # type: ignore[no-untyped-def]
    """``gain`` divided by the mean of five rows plus ``const``."""
    t0, t1, t2, t3, t4 = taps[0], taps[1], taps[2], taps[3], taps[4]
    for x in range(target.shape[0]):
        target[x] = gain / (const + t0 * r0[x] + t1 * r1[x] + t2 * r2[x] + t3 * r3[x] + t4 * r4[x])


@kernel(fastmath=FASTMATH_FLAGS)
def _quantise_strip(  # type: ignore[no-untyped-def]
    blue, green, red, start, stop, taps, const, offset, gain, buffers, out
):
    """Columns ``start`` to ``stop`` of the cells, from columns with a margin on each side."""
    rows, cells, blurred, padded, factor = buffers
    ch, cw = out.shape[1:]
    size, radius = taps.shape[0], taps.shape[0] // 2
    first, last = max(start - MARGIN_CELLS, 0), min(stop + MARGIN_CELLS, cw)
    left, right = 2 * first, blue.shape[1] if last == cw else 2 * last
    begin_strip(blue, green, red, left, right, rows)
    n = last - first
    for y in range(ch + radius):
        if y < ch:
            cell_row = cells[y % size]
            compute_cell_row(blue, green, red, left, right, y, rows, cell_row)
            _blur_row(cell_row[3 * SPAN : 3 * SPAN + n], taps, padded, blurred[y % size])
        done = y - radius
        if done < 0:
            continue
        _factors(
            blurred[max(done - 2, 0) % size], blurred[max(done - 1, 0) % size], blurred[done % size],
            blurred[min(done + 1, ch - 1) % size], blurred[min(done + 2, ch - 1) % size],
            taps, const, gain[3], factor[:n],
        )  # fmt: skip
        for c in range(CHANNELS):
            row = cells[done % size, c * SPAN + start - first : c * SPAN + stop - first]
            if c < 3:
                _quantise_row(row, offset[c], gain[c], out[c, done, start:stop])
            else:
                _scaled_row(row, factor[start - first : stop - first], out[c, done, start:stop])
