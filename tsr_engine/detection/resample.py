"""Kernels that resample a picture around a point: means over areas, then bilinear samples.

They compute only the pixels of the patch, and give the bits of OpenCV's ``resize`` (``INTER_AREA``) and ``warpAffine``
(``INTER_LINEAR``) but for ties. Pictures are rows of bytes, shape (h, 3 w), so that a row of pixels is one vector.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def span(centre, margin, size):  # type: ignore[no-untyped-def]
    """Whole pixels of ``[centre - margin, centre + margin]`` inside ``[0, size]``, at least one."""
    low = int(min(max(0.0, centre - margin), size - 1))
    return low, int(max(min(size, centre + margin), low + 1))


@njit(cache=True, nogil=True)
def _cells(centre, scale, side, reach, length):  # type: ignore[no-untyped-def]
    """Cells of about ``1 / scale`` px along one axis, within ``reach`` cells of a patch's centre.

    Returns the centre in cells, each cell's first pixel (n,), and the weights of its pixels (n, k).
    """
    low, high = span(centre, 0.75 * side / scale, length)
    count = max(1, round((high - low) * scale))
    cell = (high - low) / count
    centre = (centre - low) / cell
    first, last = span(centre, reach + 2.0, count)
    starts = np.empty(last - first, np.int32)
    weights = np.zeros((last - first, int(np.ceil(cell)) + 1), np.float32)
    for i in range(last - first):
        left, right = (first + i) * cell, (first + i + 1) * cell
        starts[i] = low + int(left)
        for k in range(weights.shape[1]):
            overlap = min(int(left) + k + 1.0, right) - max(int(left) + float(k), left)
            weights[i, k] = overlap / cell if overlap > 1e-3 else 0.0
    return centre - first, starts, weights


@njit(cache=True, nogil=True)
def _add_bytes(source, weight, target):  # type: ignore[no-untyped-def]
    for x in range(target.shape[0]):
        target[x] += weight * np.float32(source[x])


@njit(cache=True, nogil=True)
def area_means(rows, cx, cy, scale, side, reach):  # type: ignore[no-untyped-def]
    """Means over cells of about ``1 / scale`` px within ``reach`` cells of (cx, cy), and the centre in cells.

    Sums run down the rows first, where a row is a vector.
    """
    cx, left, x_weights = _cells(cx, scale, side, reach, rows.shape[1] // 3)
    cy, top, y_weights = _cells(cy, scale, side, reach, rows.shape[0])
    out = np.empty((len(top), 3 * len(left)), np.uint8)
    start, stop = 3 * left[0], min(3 * (left[-1] + x_weights.shape[1]), rows.shape[1])
    mixed = np.empty(stop - start, np.float32)
    for y in range(len(top)):
        mixed[:] = np.float32(0.0)
        for k in range(y_weights.shape[1]):
            if y_weights[y, k] > 0:
                _add_bytes(rows[top[y] + k, start:stop], y_weights[y, k], mixed)
        for x in range(len(left)):
            blue = green = red = np.float32(0.0)
            offset = 3 * left[x] - start
            for k in range(x_weights.shape[1]):
                weight = x_weights[x, k]
                if weight > 0:
                    blue += weight * mixed[offset + 3 * k]
                    green += weight * mixed[offset + 3 * k + 1]
                    red += weight * mixed[offset + 3 * k + 2]
            out[y, 3 * x], out[y, 3 * x + 1], out[y, 3 * x + 2] = np.rint(blue), np.rint(green), np.rint(red)
    return out, cx, cy


@njit(cache=True, nogil=True)
def _neighbours(centre, scale, side, length):  # type: ignore[no-untyped-def]
    """The two pixels along one axis between which each pixel of a patch lies, and their weights; (side, 2) each."""
    pixels = np.empty((side, 2), np.int32)
    weights = np.empty((side, 2), np.float32)
    for i in range(side):
        position = centre + (i + 0.5 - 0.5 * side) / scale - 0.5
        first = int(np.floor(position))
        pixels[i, 0], pixels[i, 1] = min(max(first, 0), length - 1), min(max(first + 1, 0), length - 1)
        weights[i, 1] = np.float32(position - first)
        weights[i, 0] = np.float32(1.0) - weights[i, 1]
    return pixels, weights


@njit(cache=True, nogil=True)
def _mix_bytes(first, second, weights, target):  # type: ignore[no-untyped-def]
    for x in range(target.shape[0]):
        target[x] = weights[0] * np.float32(first[x]) + weights[1] * np.float32(second[x])


@njit(cache=True, nogil=True)
def sample(rows, cx, cy, across, down, out):  # type: ignore[no-untyped-def]
    """Fills ``out`` (side, side, 3) bilinearly from rows (h, 3 w) of bytes around (cx, cy), borders replicated."""
    side = out.shape[0]
    xs, x_weights = _neighbours(cx, across, side, rows.shape[1] // 3)
    ys, y_weights = _neighbours(cy, down, side, rows.shape[0])
    start, stop = 3 * xs[0, 0], 3 * xs[-1, 1] + 3
    xs = 3 * xs - start
    mixed = np.empty(stop - start, np.float32)
    for y in range(side):
        _mix_bytes(rows[ys[y, 0], start:stop], rows[ys[y, 1], start:stop], y_weights[y], mixed)
        for x in range(side):
            a, b, left, right = xs[x, 0], xs[x, 1], x_weights[x, 0], x_weights[x, 1]
            for c in range(3):
                out[y, x, c] = np.rint(left * mixed[a + c] + right * mixed[b + c])
