"""The features of the HOG cascade: the share of one orientation in one quarter in a block's whole gradient.

The window holds blocks of several sizes and shapes. Each has four quarters with nine orientations each, which gives 36
numbers per block, normalised by the block's sum (L1, as in OpenCV's cascade trainer and in Zhu et al. 2006).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from benchmarks.systems.hog import BINS
from tsr_engine.detection.window import Window

WINDOW: Final = Window(cells=14, shrink=2, sign=24.0, pad=2)
"""The same window as the ACF detector's: 28 px with a sign of 24 px in its middle."""
FLOOR: Final = 8
"""Added to a block's sum for each of its cells: the gradient of noise in a flat sky."""
_SHAPES: Final = ((4, 4), (6, 6), (8, 8), (12, 12), (4, 8), (8, 4), (6, 12), (12, 6), (14, 14))
"""Heights and widths of the blocks in cells of 2 px."""


@dataclass(frozen=True, slots=True)
class _Rects:
    """Block and quarter of every feature: ``top, left, bottom, right`` in cells, and the orientation."""

    block: NDArray[np.int32]
    quarter: NDArray[np.int32]
    bin: NDArray[np.int32]


def _rects() -> _Rects:
    blocks, quarters, bins = [], [], []
    for height, width in _SHAPES:
        for top in range(0, WINDOW.cells - height + 1, 2):
            for left in range(0, WINDOW.cells - width + 1, 2):
                for down in (0, 1):
                    for right in (0, 1):
                        y, x = top + down * height // 2, left + right * width // 2
                        for orientation in range(BINS):
                            blocks.append((top, left, top + height, left + width))
                            quarters.append((y, x, y + height // 2, x + width // 2))
                            bins.append(orientation)
    return _Rects(np.array(blocks, np.int32), np.array(quarters, np.int32), np.array(bins, np.int32))


RECTS: Final = _rects()
FEATURES: Final = len(RECTS.bin)
"""Number of features of a window."""


def window_bytes(planes: NDArray[np.int32], rows: NDArray[np.int64], columns: NDArray[np.int64]) -> NDArray[np.uint8]:
    """All features of windows.

    Args:
        planes: integral planes of one level, shape (10, h + 1, w + 1).
        rows: rows of the windows' first cells, shape (n,).
        columns: columns of the windows' first cells, shape (n,).

    Returns:
        Shape (n, FEATURES), uint8.
    """
    out = np.empty((len(rows), FEATURES), np.uint8)
    everything = np.arange(FEATURES)
    quarter, block, floor = offsets(everything, planes.shape[1] - 1, planes.shape[2] - 1)
    starts = np.asarray(rows, np.int64) * planes.shape[2] + np.asarray(columns, np.int64)
    _gather(planes.reshape(-1), starts, quarter, block, floor, out)
    return out


def offsets(
    features: NDArray[np.int32] | NDArray[np.int64], rows: int, columns: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Offsets of features in the flat integral planes of a level of rows x columns cells.

    Returns:
        Offsets of the corners of quarter and block from a window's first cell, (..., 4) each, signs + - - +; and the
        number added to the block's sum, (...).
    """
    stride, plane = columns + 1, (rows + 1) * (columns + 1)

    def corners(rects: NDArray[np.int32], base: NDArray[np.int32] | int) -> NDArray[np.int32]:
        top, left, bottom, right = np.moveaxis(rects, -1, 0)
        places = (bottom * stride + right, top * stride + right, bottom * stride + left, top * stride + left)
        return np.stack([base + p for p in places], axis=-1).astype(np.int32)

    block = RECTS.block[features]
    area = (block[..., 2] - block[..., 0]) * (block[..., 3] - block[..., 1])
    return (
        corners(RECTS.quarter[features], RECTS.bin[features] * plane),
        corners(block, BINS * plane),
        np.asarray(area * FLOOR, dtype=np.int32),
    )


@njit(cache=True, nogil=True)
def _gather(flat, starts, quarter, block, floor, out):  # type: ignore[no-untyped-def]
    for i in range(starts.shape[0]):
        s = starts[i]
        for f in range(quarter.shape[0]):
            q, b = quarter[f], block[f]
            part = flat[s + q[0]] - flat[s + q[1]] - flat[s + q[2]] + flat[s + q[3]]
            whole = flat[s + b[0]] - flat[s + b[1]] - flat[s + b[2]] + flat[s + b[3]] + floor[f]
            # 900 bytes per unit of a share: more than about a quarter of a block's gradient in one bin saturates.
            value = np.float32(900.0) * np.float32(part) / np.float32(whole)
            out[i, f] = np.uint8(min(max(value, np.float32(0.0)), np.float32(255.0)))
