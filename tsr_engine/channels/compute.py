"""The ten aggregated channels of one picture: L, U, V, gradient magnitude, six orientations.

Definition (after Dollar et al., "Fast Feature Pyramids for Object Detection", PAMI 2014):

1. LUV from linear RGB (:mod:`tsr_engine.channels.luv`), smoothed by [1 2 1]/4 along both axes;
2. central differences; each pixel takes the gradient of its strongest colour channel;
3. the magnitude is spread over six unsigned orientations 30 degrees apart with the weight
   ``max(0, 2 cos 2d - 1)`` of the angle ``d`` to the bin's centre: it reaches zero at the neighbour's centre as
   linear interpolation does, and needs neither an arc tangent nor a division;
4. every channel is averaged over cells of ``shrink x shrink`` pixels;
5. magnitude and orientations are divided by the local mean magnitude (triangle filter, radius of about
   ``NORM_RADIUS`` px) plus ``NORM_CONST``. The division of cells takes a quarter of the time that pixels would take;
   the divisor hardly varies within a cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.kernels import kernel
from tsr_engine.records import Picture

CHANNELS: Final = 10
"""L, U, V, magnitude, orientations 0, 30, ..., 150 degrees."""
NORM_RADIUS: Final = 5
"""Radius of the normalising triangle filter, px."""
NORM_CONST: Final = 0.005
FASTMATH_FLAGS: Final = {"nnan", "ninf", "nsz"}
"""Float flags of the channels' kernels. Flags that reorder sums or fuse a product with a sum are missing: code that a
process has compiled and code that it loads from the cache would differ in the last bits."""

_C60 = np.float32(0.5)
_S60 = np.float32(np.sqrt(3) / 2)

# Y^(1/3) = t^(4/3) with t = Y^(1/4) on ((6/29)^3, 1], Chebyshev fit of degree 4, error below 2.5e-5. Two square roots
# and a polynomial run in vector registers; a table of 1024 entries does not.
_Q0, _Q1, _Q2, _Q3, _Q4 = (
    np.float32(v) for v in (-0.01931906727, 0.54913543960, 0.69969924731, -0.30396922431, 0.07447097096)
)


@kernel(fastmath=FASTMATH_FLAGS)
def luv(blue, green, red):  # type: ignore[no-untyped-def]
    """L, U and V of one pixel, from bytes."""
    unit = np.float32(1.0 / 255.0)
    b = np.float32(blue) * unit
    g = np.float32(green) * unit
    r = np.float32(red) * unit
    cx = np.float32(0.430574) * r + np.float32(0.341550) * g + np.float32(0.178325) * b
    cy = np.float32(0.222015) * r + np.float32(0.706655) * g + np.float32(0.071330) * b
    cz = np.float32(0.020183) * r + np.float32(0.129553) * g + np.float32(0.939180) * b
    d = np.float32(1.0) / (cx + np.float32(15.0) * cy + np.float32(3.0) * cz + np.float32(1e-12))
    t = np.sqrt(np.sqrt(cy))
    root = _Q0 + t * (_Q1 + t * (_Q2 + t * (_Q3 + t * _Q4)))
    bright = np.float32(116.0 / 270.0) * root - np.float32(16.0 / 270.0)
    dark = np.float32(24389.0 / 27.0 / 270.0) * cy
    lightness = bright if cy > np.float32(216.0 / 24389.0) else dark
    return (
        lightness,
        lightness * (np.float32(52.0) * cx * d - np.float32(13.0 * 0.197833)) + np.float32(88.0 / 270.0),
        lightness * (np.float32(117.0) * cy * d - np.float32(13.0 * 0.468331)) + np.float32(134.0 / 270.0),
    )


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _luv_row(blue, green, red, out_l, out_u, out_v):  # type: ignore[no-untyped-def]
    """Converts three uint8 rows (w,) to three LUV rows (w + 2,) with one replicated pixel on each side."""
    w = blue.shape[0]
    for x in range(w):
        out_l[x + 1], out_u[x + 1], out_v[x + 1] = luv(blue[x], green[x], red[x])
    out_l[0], out_u[0], out_v[0] = out_l[1], out_u[1], out_v[1]
    out_l[w + 1], out_u[w + 1], out_v[w + 1] = out_l[w], out_u[w], out_v[w]


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _smooth_row(above, here, below, column, out):  # type: ignore[no-untyped-def]
    """Smooths three rows (w + 2,) by [1 2 1]/4 along both axes to one row (w + 2,), borders replicated."""
    n = here.shape[0]
    for x in range(n):
        column[x] = np.float32(0.0625) * (above[x] + below[x]) + np.float32(0.125) * here[x]
    for x in range(1, n - 1):
        out[x] = column[x - 1] + np.float32(2.0) * column[x] + column[x + 1]
    out[0] = out[1]
    out[n - 1] = out[n - 2]


@kernel(fastmath=FASTMATH_FLAGS)
def gradient_orientations(gx, gy, gx1, gy1, gx2, gy2):  # type: ignore[no-untyped-def]
    """Magnitude of the strongest of three gradients, and its six orientations."""
    zero = np.float32(0.0)
    e = gx * gx + gy * gy
    e1 = gx1 * gx1 + gy1 * gy1
    e2 = gx2 * gx2 + gy2 * gy2
    first = e1 > e
    gx = gx1 if first else gx
    gy = gy1 if first else gy
    e = e1 if first else e
    second = e2 > e
    gx = gx2 if second else gx
    gy = gy2 if second else gy
    e = e2 if second else e
    inv = np.float32(1.0) / np.sqrt(e + np.float32(1e-18))
    mag = e * inv
    # The double-angle vector times 2 / mag, of length 2 * mag. Bins are 60 degrees apart in double angle.
    c = np.float32(2.0) * (gx * gx - gy * gy) * inv
    s = np.float32(4.0) * gx * gy * inv
    p1 = _C60 * c + _S60 * s
    p2 = _S60 * s - _C60 * c
    return (
        mag,
        max(zero, c - mag),
        max(zero, p1 - mag),
        max(zero, p2 - mag),
        max(zero, -c - mag),
        max(zero, -p1 - mag),
        max(zero, -p2 - mag),
    )


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _gradient_row(a0, a1, a2, h0, h1, h2, b0, b1, b2, m, o0, o1, o2, o3, o4, o5):  # type: ignore[no-untyped-def]
    """Adds one row's magnitude and orientations, (w,) each, from the LUV rows above, here and below, (w + 2,) each."""
    for x in range(m.shape[0]):
        values = gradient_orientations(
            h0[x + 2] - h0[x], b0[x + 1] - a0[x + 1],
            h1[x + 2] - h1[x], b1[x + 1] - a1[x + 1],
            h2[x + 2] - h2[x], b2[x + 1] - a2[x + 1],
        )  # fmt: skip
        m[x] += values[0]
        o0[x] += values[1]
        o1[x] += values[2]
        o2[x] += values[3]
        o3[x] += values[4]
        o4[x] += values[5]
        o5[x] += values[6]


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _add_row(source, target):  # type: ignore[no-untyped-def]
    """Adds a padded row (w + 2,) to (w,)."""
    for x in range(target.shape[0]):
        target[x] += source[x + 1]


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _fold_row(source, target, shrink, factor):  # type: ignore[no-untyped-def]
    """Sums ``shrink`` neighbours of a row times ``factor`` into one cell each, and clears the row."""
    if shrink == 1:
        for x in range(target.shape[0]):
            target[x] = source[x] * factor
    elif shrink == 2:
        for x in range(target.shape[0]):
            target[x] = (source[2 * x] + source[2 * x + 1]) * factor
    else:
        for x in range(target.shape[0]):
            total = np.float32(0.0)
            for i in range(shrink):
                total += source[x * shrink + i]
            target[x] = total * factor
    source[:] = np.float32(0.0)


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _make_buffers(blue, green, red):  # type: ignore[no-untyped-def]
    """Row buffers for :func:`_cell_row`: three rows of LUV and of smoothed LUV, a scratch row, ten sums."""
    h, w = blue.shape
    raw = np.empty((9, w + 2), np.float32)
    smooth = np.empty((9, w + 2), np.float32)
    column = np.empty(w + 2, np.float32)
    acc = np.zeros((CHANNELS, w), np.float32)
    for y in range(min(2, h)):
        _luv_row(blue[y], green[y], red[y], raw[3 * y], raw[3 * y + 1], raw[3 * y + 2])
    for c in range(3):
        _smooth_row(raw[c], raw[c], raw[c if h == 1 else 3 + c], column, smooth[c])
    return raw, smooth, column, acc


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _cell_row(blue, green, red, row, shrink, buffers, out):  # type: ignore[no-untyped-def]
    """Steps 1 to 4 for one row of cells, into ``out[:, row]`` of (10, h // shrink, w // shrink), in order of rows.

    The buffers hold only three rows of LUV and of smoothed LUV, not the picture.
    """
    raw, smooth, column, acc = buffers
    h = blue.shape[0]
    colour_factor = np.float32(1.0 / (shrink * shrink))
    gradient_factor = np.float32(0.5 / (shrink * shrink))  # the differences span two pixels
    for y in range(row * shrink, (row + 1) * shrink):
        here, up, down = 3 * (y % 3), 3 * (max(y - 1, 0) % 3), 3 * (min(y + 1, h - 1) % 3)
        if y + 1 < h:
            below = 3 * (min(y + 2, h - 1) % 3)
            if y + 2 < h:
                _luv_row(blue[y + 2], green[y + 2], red[y + 2], raw[below], raw[below + 1], raw[below + 2])
            for c in range(3):
                _smooth_row(raw[here + c], raw[down + c], raw[below + c], column, smooth[down + c])
        _gradient_row(
            smooth[up], smooth[up + 1], smooth[up + 2],
            smooth[here], smooth[here + 1], smooth[here + 2],
            smooth[down], smooth[down + 1], smooth[down + 2],
            acc[3], acc[4], acc[5], acc[6], acc[7], acc[8], acc[9],
        )  # fmt: skip
        for c in range(3):
            _add_row(smooth[here + c], acc[c])
    for c in range(CHANNELS):
        _fold_row(acc[c], out[c, row], shrink, colour_factor if c < 3 else gradient_factor)


@njit(cache=True, nogil=True, fastmath=FASTMATH_FLAGS, error_model="numpy")
def _cells(blue, green, red, shrink):  # type: ignore[no-untyped-def]
    """Steps 1 to 4: three (h, w) uint8 planes to (10, h // shrink, w // shrink)."""
    rows, columns = blue.shape[0] // shrink, blue.shape[1] // shrink
    out = np.empty((CHANNELS, rows, columns), np.float32)
    buffers = _make_buffers(blue, green, red)
    for row in range(rows):
        _cell_row(blue, green, red, row, shrink, buffers, out)
    return out


def check_picture(picture: Picture, shrink: int = 1) -> None:
    """Check that a picture has the right type and shape and at least one cell of ``shrink`` px.

    Raises:
        ValueError: the picture is not BGR uint8, or is smaller than one cell.
    """
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        raise ValueError(f"A picture must be uint8 of shape (h, w, 3). Got {picture.dtype} {picture.shape} instead.")
    if min(picture.shape[:2]) < shrink or shrink < 1:
        raise ValueError(f"A picture must hold one cell of {shrink} px. Got shape {picture.shape} instead.")


@lru_cache
def triangle(radius: int) -> NDArray[np.float32]:
    """Taps of a triangle filter, shape (2 * radius + 1,), with sum 1."""
    taps = np.concatenate([np.arange(1, radius + 2), np.arange(radius, 0, -1)]).astype(np.float32)
    return np.asarray(taps / taps.sum(), dtype=np.float32)


def norm_radius(shrink: int) -> int:
    """Radius in cells of the normalising filter for cells of ``shrink`` px."""
    return max(1, round(NORM_RADIUS / shrink))


def compute_channels(picture: Picture, shrink: int = 2) -> NDArray[np.float32]:
    """The ten channels of a picture.

    Args:
        picture: BGR, uint8, shape (h, w, 3), at least ``shrink`` px on each side.
        shrink: cell size in px; rows and columns beyond the last whole cell are dropped.

    Returns:
        Shape (10, h // shrink, w // shrink), float32: L in [0, 0.37], U and V in [0, 1], normalised magnitude and
        orientations >= 0 with a local mean of about 1 for the magnitude.

    Raises:
        ValueError: the picture is not BGR uint8, or is smaller than one cell.
    """
    check_picture(picture, shrink)
    return plane_channels(cv2.split(picture), shrink)


def plane_channels(planes: Sequence[NDArray[np.uint8]] | NDArray[np.uint8], shrink: int) -> NDArray[np.float32]:
    """:func:`compute_channels` of a picture that is given as planes: blue, green and red, uint8, shape (h, w) each."""
    blue, green, red = planes
    cells: NDArray[np.float32] = _cells(blue, green, red, shrink)
    taps = triangle(norm_radius(shrink))
    divisor = cv2.sepFilter2D(cells[3], cv2.CV_32F, taps, taps, borderType=cv2.BORDER_REPLICATE)
    divisor += NORM_CONST
    cells[3:] /= divisor
    return cells
