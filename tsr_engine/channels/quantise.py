"""Channels as bytes, the input of the trees.

Eight bits a channel are enough for thresholds. They quarter the memory traffic, and one vector instruction compares
dozens of windows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.channels.compute import (
    CHANNELS,
    NORM_CONST,
    cell_row,
    check_picture,
    norm_radius,
    start_rows,
    triangle,
)
from tsr_engine.records import Picture

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
    """``quantise(compute_channels(picture, shrink))`` in one pass; values differ by at most 1.

    Only the rows of cells that the normalising filter spans are in memory as floats; each is normalised and written as
    bytes. This saves most of the memory traffic, which costs as much as the arithmetic.

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
    taps = triangle(norm_radius(shrink))
    _stream(blue, green, red, shrink, taps, np.float32(NORM_CONST), _OFFSET, _GAIN, out)
    return out


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _row(source, offset, gain, target):  # type: ignore[no-untyped-def]
    for x in range(source.shape[0]):
        value = (source[x] - offset) * gain + np.float32(0.5)
        value = min(max(value, np.float32(0.0)), np.float32(255.0))
        target[x] = np.uint8(np.int32(value))


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _scaled_row(source, factor, target):  # type: ignore[no-untyped-def]
    for x in range(source.shape[0]):
        value = min(source[x] * factor[x] + np.float32(0.5), np.float32(255.0))
        target[x] = np.uint8(np.int32(value))


@njit(cache=True, nogil=True)
def _quantise(channels, out, offset, gain):  # type: ignore[no-untyped-def]
    for c in range(channels.shape[0]):
        for y in range(channels.shape[1]):
            _row(channels[c, y], offset[c], gain[c], out[c, y])


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _add_scaled(source, tap, target):  # type: ignore[no-untyped-def]
    for x in range(source.shape[0]):
        target[x] += tap * source[x]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _blur_row(source, taps, padded, target):  # type: ignore[no-untyped-def]
    """Filters a row (n,), borders replicated; ``padded`` is working memory of (n + 2 * radius,)."""
    n, radius = source.shape[0], taps.shape[0] // 2
    padded[:radius] = source[0]
    padded[radius : radius + n] = source
    padded[radius + n :] = source[n - 1]
    target[:] = np.float32(0.0)
    for k in range(taps.shape[0]):
        _add_scaled(padded[k : k + n], taps[k], target)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _invert(divisor, gain):  # type: ignore[no-untyped-def]
    for x in range(divisor.shape[0]):
        divisor[x] = gain / divisor[x]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _stream(blue, green, red, shrink, taps, const, offset, gain, out):  # type: ignore[no-untyped-def]
    ch, cw = blue.shape[0] // shrink, blue.shape[1] // shrink
    size, radius = taps.shape[0], taps.shape[0] // 2
    cells = np.empty((CHANNELS, size, cw), np.float32)
    blurred = np.empty((size, cw), np.float32)
    padded = np.empty(cw + 2 * radius, np.float32)
    factor = np.empty(cw, np.float32)
    rows = start_rows(blue, green, red)
    for y in range(ch + radius):
        if y < ch:
            cell_row(blue, green, red, y, shrink, rows, cells, y % size)
            _blur_row(cells[3, y % size], taps, padded, blurred[y % size])
        done = y - radius
        if done < 0:
            continue
        factor[:] = const
        for k in range(size):
            _add_scaled(blurred[min(max(done + k - radius, 0), ch - 1) % size], taps[k], factor)
        _invert(factor, gain[3])
        at = done % size
        for c in range(3):
            _row(cells[c, at], offset[c], gain[c], out[c, done])
        for c in range(3, CHANNELS):
            _scaled_row(cells[c, at], factor, out[c, done])
