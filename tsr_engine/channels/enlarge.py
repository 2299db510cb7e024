"""Enlarges planes from two to three pixels: the first step of every search with the default settings.

The weights of this ratio repeat every three pixels, so that whole vectors of pixels share them. OpenCV takes any ratio
and looks up weights and neighbours for each pixel. The results equal those of ``cv2.resize`` to the bit: bilinear
interpolation in whole numbers, and means over areas.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.rows import copy_row

__all__ = ["enlarge", "fits"]

# Weights in 1/2048. A new pixel lies in the middle of two old ones, or a sixth of a pixel beside one.
_NEAR, _FAR, _HALF = 1707, 341, 1024


def fits(source: NDArray[np.uint8], size: tuple[int, int]) -> bool:
    """Whether ``size`` (width, height) is exactly 3/2 of the planes (n, h, w)."""
    height, width = source.shape[1:]
    return min(height, width) > 0 and (2 * size[0], 2 * size[1]) == (3 * width, 3 * height)


@njit(cache=True, nogil=True, error_model="numpy")
def _along(left, here, beside, right, out):  # type: ignore[no-untyped-def]
    """Enlarges a row (w,) to (3 w / 2,), in 1/128: two pixels and their neighbours give three new ones."""
    for k in range(out.shape[0] // 3):
        a, b = np.uint32(left[2 * k]), np.uint32(here[2 * k])
        c, d = np.uint32(beside[2 * k]), np.uint32(right[2 * k])
        # Without a cast after each step, Numba computes in 64 bits.
        first = np.uint32(np.uint32(a * np.uint32(_FAR)) + np.uint32(b * np.uint32(_NEAR)))
        third = np.uint32(np.uint32(c * np.uint32(_NEAR)) + np.uint32(d * np.uint32(_FAR)))
        out[3 * k] = np.uint16(first >> np.uint32(4))
        out[3 * k + 1] = np.uint16(np.uint32(b + c) << np.uint32(6))
        out[3 * k + 2] = np.uint16(third >> np.uint32(4))


@njit(cache=True, nogil=True, error_model="numpy")
def _down(one, other, first, second, out):  # type: ignore[no-untyped-def]
    """Combines two rows in 1/128, with their weights in 1/2048, to a row of bytes."""
    # 16-bit weights let the compiler use 16-bit products; otherwise it uses 32 bits.
    p, q = np.uint32(np.uint16(first)), np.uint32(np.uint16(second))
    for x in range(out.shape[0]):
        a = np.uint16(np.uint32(p * np.uint32(one[x])) >> np.uint32(16))
        b = np.uint16(np.uint32(q * np.uint32(other[x])) >> np.uint32(16))
        out[x] = np.uint8(np.uint16(np.uint16(a + b) + np.uint16(2)) >> np.uint16(2))


@njit(cache=True, nogil=True, error_model="numpy")
def _mean(one, other, out):  # type: ignore[no-untyped-def]
    """Means of 2 x 2 bytes of two rows, halves rounded up."""
    for x in range(out.shape[0]):
        first = np.uint16(np.uint16(one[2 * x]) + np.uint16(one[2 * x + 1]))
        second = np.uint16(np.uint16(other[2 * x]) + np.uint16(other[2 * x + 1]))
        out[x] = np.uint8(np.uint16(np.uint16(first + second) + np.uint16(2)) >> np.uint16(2))


@njit(cache=True, nogil=True, error_model="numpy")
def enlarge(source, target, halved):  # type: ignore[no-untyped-def]
    """Enlarges planes and halves the result while its rows are in the first-level cache.

    Args:
        source: planes (n, h, w), uint8; h and w even; borders are replicated.
        target: planes (n, 3 h / 2, 3 w / 2), uint8; receives the result.
        halved: planes (n, 3 h / 4, 3 w / 4), rounded down, uint8; receives the means of 2 x 2 px of the result.
    """
    planes, h, w = source.shape
    padded = np.empty(w + 2, np.uint8)
    rows = np.empty((2, 3 * w // 2), np.uint16)
    for c in range(planes):
        made = 0
        for y in range(h):
            copy_row(source[c, y], padded[1 : w + 1])
            padded[0], padded[w + 1] = padded[1], padded[w]
            here, above = rows[y % 2], rows[(y + 1) % 2]
            _along(padded, padded[1:], padded[2:], padded[3:], here)
            if y % 2:
                _down(above, here, _HALF, _HALF, target[c, y // 2 * 3 + 1])
                continue
            if y:
                _down(above, here, _NEAR, _FAR, target[c, y // 2 * 3 - 1])
            _down(above if y else here, here, _FAR, _NEAR, target[c, y // 2 * 3])
            while 2 * made < y // 2 * 3:
                _mean(target[c, 2 * made], target[c, 2 * made + 1], halved[c, made])
                made += 1
        last = rows[(h - 1) % 2]
        _down(last, last, _NEAR, _FAR, target[c, h // 2 * 3 - 1])
        while made < halved.shape[1]:
            _mean(target[c, 2 * made], target[c, 2 * made + 1], halved[c, made])
            made += 1
