"""Two views of a crop, shifted against each other.

A classifier's result changes with the place of the box and, in the dark, with the noise of single pixels. The mean over
two views, shifted by 1.5 px of 48 along the diagonal in both directions, depends less on both. A view between pixels
also averages four of them.
"""

from __future__ import annotations

import numba as nb
import numpy as np
from numpy.typing import NDArray

from tsr_engine.row_copy import copy_row


def diagonal_pairs(patches: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Patches moved by 1.5 px to the upper left and to the lower right, borders replicated.

    Args:
        patches: shape (n, s, s, 3).

    Returns:
        Shape (2 n, s, s, 3): the two views of the first patch, then those of the second.
    """
    count, height, width = patches.shape[:3]
    out = np.empty((2 * count, height, width, 3), dtype=np.uint8)
    rows = np.ascontiguousarray(patches).reshape(count, height, 3 * width)
    _move(rows, out.reshape(2 * count, height, 3 * width))
    return out


@nb.njit(cache=True, nogil=True)
def _move(patches, out):  # type: ignore[no-untyped-def]
    """Makes both views from the same means of four neighbours, shifted up and left, or down and right.

    Rows hold three values for each pixel. The patch is padded by two pixels on each side; row ``r`` of the means lies
    between its rows ``r - 2`` and ``r - 1``.
    """
    height, length = patches.shape[1:3]
    sums = np.empty(length + 12, dtype=np.uint16)
    means = np.empty(length + 9, dtype=np.uint8)
    for i in range(len(patches)):
        for r in range(height + 3):
            above, below = patches[i, min(max(r - 2, 0), height - 1)], patches[i, min(max(r - 1, 0), height - 1)]
            inner = sums[6 : 6 + length]
            for x in range(length):
                inner[x] = np.uint16(above[x]) + np.uint16(below[x])
            for x in range(6):
                sums[x], sums[length + 6 + x] = inner[x % 3], inner[length - 3 + x % 3]
            left, right = sums[: length + 9], sums[3:]
            for x in range(length + 9):
                means[x] = np.uint16(left[x] + right[x] + np.uint16(2)) >> np.uint16(2)
            if r < height:
                copy_row(means[:length], out[2 * i + 1, r])
            if r >= 3:
                copy_row(means[9:], out[2 * i, r - 3])
