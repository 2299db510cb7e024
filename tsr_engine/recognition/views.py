"""Two views of a crop, moved against each other: what both see is the sign's, what one sees is the place's.

A classifier's answer changes with the place of the box and, in the dark, with the noise of single pixels. The mean over
two views, each 1.5 px of 48 from the crop's place along the diagonal, depends less on either: between pixels a view is
the mean of four of them.
"""

from __future__ import annotations

import numba as nb
import numpy as np
from numpy.typing import NDArray

__all__ = ["diagonal_pairs"]


def diagonal_pairs(patches: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Patches moved by 1.5 px to the upper left and to the lower right; the border is replicated.

    Args:
        patches: shape (n, s, s, 3).

    Returns:
        Shape (2 n, s, s, 3): the two views of the first patch, then those of the second.
    """
    out = np.empty((2 * len(patches), *patches.shape[1:]), dtype=np.uint8)
    _move(np.ascontiguousarray(patches), out)
    return out


@nb.njit(cache=True, nogil=True)
def _move(patches, out):  # type: ignore[no-untyped-def]
    """A picture moved to the upper left shows at (y, x) what was between (y + 1, x + 1) and (y + 2, x + 2)."""
    height, width = patches.shape[1:3]
    for i in range(len(patches)):
        patch = patches[i]
        for view in range(2):
            for y in range(height):
                near = min(y + 1, height - 1) if view == 0 else max(y - 1, 0)
                far = min(y + 2, height - 1) if view == 0 else max(y - 2, 0)
                for x in range(width):
                    left = min(x + 1, width - 1) if view == 0 else max(x - 1, 0)
                    right = min(x + 2, width - 1) if view == 0 else max(x - 2, 0)
                    for c in range(3):
                        total = np.int32(patch[near, left, c]) + np.int32(patch[near, right, c])
                        total += np.int32(patch[far, left, c]) + np.int32(patch[far, right, c])
                        out[2 * i + view, y, x, c] = np.uint8((total + 2) // 4)
