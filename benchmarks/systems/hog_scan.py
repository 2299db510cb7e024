"""The HOG cascade over every window of a picture.

Trees have depth 2. The first few are evaluated for whole rows of windows at once, which the compiler vectorises.
Survivors continue tree by tree until one drops them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from benchmarks.systems.hog import integral, orientation_cells
from benchmarks.systems.hog_blocks import WINDOW, offsets
from tsr_engine.channels.pyramid import level_scales
from tsr_engine.detection.trees import TreeEnsemble
from tsr_engine.records import FloatArray, Picture

PER_OCTAVE: Final = 6
"""Scales per octave, as in the ACF detector."""
DENSE: Final = 6
"""Number of first trees that are evaluated for whole rows."""


@dataclass(frozen=True, slots=True)
class HogLevel:
    """One scale of a picture.

    Attributes:
        index: scale = first scale * 2 ** (-index / PER_OCTAVE).
        planes: integral planes, shape (10, rows + 1, columns + 1), with a border of ``WINDOW.pad`` cells.
        scale_x: px of the level per px of the picture.
        scale_y: px of the level per px of the picture, along y.
    """

    index: int
    planes: NDArray[np.int32]
    scale_x: float
    scale_y: float

    @property
    def windows(self) -> tuple[int, int]:
        """Numbers of rows and columns of windows."""
        return self.planes.shape[1] - WINDOW.cells, self.planes.shape[2] - WINDOW.cells

    def boxes(self, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> FloatArray:
        """Boxes (n, 4), px of the picture, of the signs in windows with these first cells."""
        x = ((columns - WINDOW.pad) * WINDOW.shrink + WINDOW.margin) / self.scale_x
        y = ((rows - WINDOW.pad) * WINDOW.shrink + WINDOW.margin) / self.scale_y
        return np.stack([x, y, x + WINDOW.sign / self.scale_x, y + WINDOW.sign / self.scale_y], axis=-1)


def scales_of(width: int, height: int, min_width: float) -> FloatArray:
    """Scales at which signs from ``min_width`` px fill the window, descending."""
    return level_scales(WINDOW.sign / min_width, WINDOW.side / min(width, height), PER_OCTAVE)


def levels(picture: Picture, scales: Sequence[float] | FloatArray) -> Iterator[HogLevel]:
    """Yield the levels of a BGR picture, largest first, each made on demand."""
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    border = WINDOW.pad * WINDOW.shrink
    for index, scale in enumerate(scales):
        size = (int(grey.shape[1] * scale), int(grey.shape[0] * scale))
        if min(size) < WINDOW.side - 2 * border:
            return
        resized = cv2.resize(grey, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
        framed = cv2.copyMakeBorder(resized, border, border, border, border, cv2.BORDER_REPLICATE)
        planes = integral(orientation_cells(np.asarray(framed, np.uint8), WINDOW.shrink))
        yield HogLevel(index, planes, size[0] / grey.shape[1], size[1] / grey.shape[0])


def scan(
    level: HogLevel, cascade: TreeEnsemble, rows: tuple[int, int] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int32]]:
    """Windows of one level that pass the cascade.

    Args:
        level: see :class:`HogLevel`.
        cascade: trees of depth 2 over the features of :mod:`benchmarks.systems.hog_blocks`; rejection thresholds of
            the first ``DENSE - 1`` trees are not looked at.
        rows: first and last + 1 row of windows; unset: all.

    Returns:
        Row, column and score (in 1/UNIT) of each, in scan order.

    Raises:
        ValueError: the trees have another depth.
    """
    if cascade.depth != 2:
        raise ValueError(f"The scan needs trees of depth 2. Got {cascade.depth} instead.")
    down, across = level.windows
    first, last = (0, down) if rows is None else (max(0, rows[0]), min(down, rows[1]))
    if across < 1 or last <= first:
        none = np.zeros(0, np.int64)
        return none, none, np.zeros(0, np.int32)
    quarter, block, floor = offsets(cascade.features, level.planes.shape[1] - 1, level.planes.shape[2] - 1)
    out = np.empty(((last - first) * across, 3), np.int32)
    found = _scan(
        level.planes.reshape(-1), level.planes.shape[2], first, last, quarter, block, floor,
        cascade.thresholds, cascade.leaves, cascade.rejection, min(DENSE, len(cascade)),
        np.empty(across, np.int32), np.empty((3, across), np.bool_), out,
    )  # fmt: skip
    return out[:found, 0].astype(np.int64), out[:found, 1].astype(np.int64), out[:found, 2].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _ask_row(a, b, c, d, e, f, g, h, floor, threshold, out):  # type: ignore[no-untyped-def]
    """Evaluates one node for a row of windows: whether the quarter's share reaches the threshold."""
    limit = np.float32(threshold)
    for x in range(out.shape[0]):
        part = np.int32(a[x] - b[x]) - np.int32(c[x] - d[x])
        whole = np.int32(e[x] - f[x]) - np.int32(g[x] - h[x]) + floor
        out[x] = np.float32(900.0) * np.float32(part) >= limit * np.float32(whole)


@njit(cache=True, nogil=True, error_model="numpy")
def _answer_row(first, low, high, leaf, acc):  # type: ignore[no-untyped-def]
    v0, v1, v2, v3 = np.int32(leaf[0]), np.int32(leaf[1]), np.int32(leaf[2]), np.int32(leaf[3])
    for x in range(acc.shape[0]):
        left = v1 if low[x] else v0
        right = v3 if high[x] else v2
        acc[x] += right if first[x] else left


@njit(cache=True, nogil=True, error_model="numpy")
def _ask(flat, s, q, b, floor, threshold):  # type: ignore[no-untyped-def]
    part = flat[s + q[0]] - flat[s + q[1]] - flat[s + q[2]] + flat[s + q[3]]
    whole = flat[s + b[0]] - flat[s + b[1]] - flat[s + b[2]] + flat[s + b[3]] + floor
    return np.float32(900.0) * np.float32(part) >= np.float32(threshold) * np.float32(whole)


@njit(cache=True, nogil=True, error_model="numpy")
def _scan(flat, stride, first, last, quarter, block, floor, thresholds, leaves, rejection, dense, acc, answers, out):  # type: ignore[no-untyped-def]
    across = acc.shape[0]
    found = 0
    for y in range(first, last):
        base = y * stride
        for x in range(across):
            acc[x] = 0
        for t in range(dense):
            for k in range(3):
                q, b = quarter[t, k], block[t, k]
                _ask_row(
                    flat[base + q[0] :], flat[base + q[1] :], flat[base + q[2] :], flat[base + q[3] :],
                    flat[base + b[0] :], flat[base + b[1] :], flat[base + b[2] :], flat[base + b[3] :],
                    floor[t, k], thresholds[t, k], answers[k],
                )  # fmt: skip
            _answer_row(answers[0], answers[1], answers[2], leaves[t], acc)
        for x in range(across):
            total = acc[x]
            if total < rejection[dense - 1]:
                continue
            s = base + x
            alive = True
            for t in range(dense, quarter.shape[0]):
                k = 2 if _ask(flat, s, quarter[t, 0], block[t, 0], floor[t, 0], thresholds[t, 0]) else 1
                right = _ask(flat, s, quarter[t, k], block[t, k], floor[t, k], thresholds[t, k])
                total += leaves[t, 2 * (k - 1) + (1 if right else 0)]
                if total < rejection[t]:
                    alive = False
                    break
            if alive:
                out[found, 0], out[found, 1], out[found, 2] = y, x, total
                found += 1
    return found
