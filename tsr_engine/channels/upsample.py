"""Enlarges planes from two to three pixels: the first step of every search with the default settings.

The weights of this ratio repeat every three pixels, so that whole vectors of pixels share them. OpenCV takes any ratio
and looks up weights and neighbours for each pixel. The results equal those of ``cv2.resize`` to the bit: bilinear
interpolation in whole numbers, and means over areas.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tsr_engine.kernels import kernel
from tsr_engine.row_copy import copy_row

__all__ = ["is_three_halves", "upsample"]

# Weights in 1/2048. A new pixel lies in the middle of two old ones, or a sixth of a pixel beside one.
_NEAR, _FAR, _HALF = 1707, 341, 1024


def is_three_halves(source: NDArray[np.uint8], size: tuple[int, int]) -> bool:
    """Whether ``size`` (width, height) is exactly 3/2 of the planes (n, h, w)."""
    height, width = source.shape[1:]
    return min(height, width) > 0 and (2 * size[0], 2 * size[1]) == (3 * width, 3 * height)


@kernel()
def _upsample_row(left, first_pixel, second_pixel, right, out):  # type: ignore[no-untyped-def]
    """Enlarges a row (w,) to (3 w / 2,), in 1/128: two pixels and their neighbours give three new ones."""
    for k in range(out.shape[0] // 3):
        a, b = np.uint32(left[2 * k]), np.uint32(first_pixel[2 * k])
        c, d = np.uint32(second_pixel[2 * k]), np.uint32(right[2 * k])
        # Without a cast after each step, Numba computes in 64 bits.
        first = np.uint32(np.uint32(a * np.uint32(_FAR)) + np.uint32(b * np.uint32(_NEAR)))
        third = np.uint32(np.uint32(c * np.uint32(_NEAR)) + np.uint32(d * np.uint32(_FAR)))
        out[3 * k] = np.uint16(first >> np.uint32(4))
        out[3 * k + 1] = np.uint16(np.uint32(b + c) << np.uint32(6))
        out[3 * k + 2] = np.uint16(third >> np.uint32(4))


@kernel()
def _blend_rows(upper, lower, first, second, out):  # type: ignore[no-untyped-def]
    """Combines two rows in 1/128, with their weights in 1/2048, to a row of bytes."""
    # 16-bit weights let the compiler use 16-bit products; otherwise it uses 32 bits.
    p, q = np.uint32(np.uint16(first)), np.uint32(np.uint16(second))
    for x in range(out.shape[0]):
        a = np.uint16(np.uint32(p * np.uint32(upper[x])) >> np.uint32(16))
        b = np.uint16(np.uint32(q * np.uint32(lower[x])) >> np.uint32(16))
        out[x] = np.uint8(np.uint16(np.uint16(a + b) + np.uint16(2)) >> np.uint16(2))


@kernel()
def _halve_rows(upper, lower, out):  # type: ignore[no-untyped-def]
    """Means of 2 x 2 bytes of two rows, halves rounded up."""
    for x in range(out.shape[0]):
        first = np.uint16(np.uint16(upper[2 * x]) + np.uint16(upper[2 * x + 1]))
        second = np.uint16(np.uint16(lower[2 * x]) + np.uint16(lower[2 * x + 1]))
        out[x] = np.uint8(np.uint16(np.uint16(first + second) + np.uint16(2)) >> np.uint16(2))


def upsample(source: NDArray[np.uint8], target: NDArray[np.uint8], halved: NDArray[np.uint8]) -> None:
    """Enlarges planes and halves the result while its rows are in the first-level cache.

    Args:
        source: planes (n, h, w), uint8; h and w even; borders are replicated.
        target: planes (n, 3 h / 2, 3 w / 2), uint8; receives the result.
        halved: planes (n, 3 h / 4, 3 w / 4), rounded down, uint8; receives the means of 2 x 2 px of the result.
    """
    width = source.shape[2]
    _upsample(source, target, halved, np.empty(width + 2, np.uint8), np.empty((2, 3 * width // 2), np.uint16))


@kernel()
def _upsample(source, target, halved, padded, rows):  # type: ignore[no-untyped-def]
    planes, h, w = source.shape
    for c in range(planes):
        halved_rows = 0
        for y in range(h):
            copy_row(source[c, y], padded[1 : w + 1])
            padded[0], padded[w + 1] = padded[1], padded[w]
            current, previous = rows[y % 2], rows[(y + 1) % 2]
            _upsample_row(padded, padded[1:], padded[2:], padded[3:], current)
            if y % 2:
                _blend_rows(previous, current, _HALF, _HALF, target[c, y // 2 * 3 + 1])
                continue
            if y:
                _blend_rows(previous, current, _NEAR, _FAR, target[c, y // 2 * 3 - 1])
            _blend_rows(previous if y else current, current, _FAR, _NEAR, target[c, y // 2 * 3])
            while 2 * halved_rows < y // 2 * 3:
                _halve_rows(target[c, 2 * halved_rows], target[c, 2 * halved_rows + 1], halved[c, halved_rows])
                halved_rows += 1
        last = rows[(h - 1) % 2]
        _blend_rows(last, last, _NEAR, _FAR, target[c, h // 2 * 3 - 1])
        while halved_rows < halved.shape[1]:
            _halve_rows(target[c, 2 * halved_rows], target[c, 2 * halved_rows + 1], halved[c, halved_rows])
            halved_rows += 1
