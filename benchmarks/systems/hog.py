"""Histograms of oriented gradients, computed once for a whole picture.

The wheel of OpenCV 5 lacks ``HOGDescriptor`` (it moved to contrib's ``xobjdetect``), so two systems of the comparison
share this module. It has nine unsigned bins 20 degrees apart; votes are divided between the two nearest (Dalal & Triggs
2005) and summed over square cells. Histograms of rectangles come from integral planes (Zhu et al. 2006, "Fast Human
Detection Using a Cascade of Histograms of Oriented Gradients").
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.records import Picture

BINS: Final = 9
"""Unsigned orientations: 0, 20, ..., 160 degrees."""
PLANES: Final = BINS + 1
"""Number of planes: the orientations, then their sum."""


def orientation_cells(picture: Picture, cell: int) -> NDArray[np.int32]:
    """Orientation histograms of square cells.

    Args:
        picture: uint8, grey (h, w) or BGR (h, w, 3); the colour channel with the strongest gradient counts.
        cell: side of a cell, px; incomplete cells at the right and below are dropped.

    Returns:
        Shape (10, h // cell, w // cell): twice the sum of magnitudes in grey values, by orientation and in total.

    Raises:
        ValueError: the picture is not uint8, or is smaller than one cell.
    """
    if picture.dtype != np.uint8 or picture.ndim not in (2, 3) or min(picture.shape[:2]) < cell:
        raise ValueError(f"Expected a uint8 picture of at least {cell} px a side. Got {picture.dtype} {picture.shape}.")
    planes = picture[None] if picture.ndim == 2 else np.moveaxis(picture, -1, 0)
    cells: NDArray[np.int32] = _voted(planes[None], cell)[0]
    return cells


def patch_cells(patches: NDArray[np.uint8], cell: int) -> NDArray[np.int32]:
    """Orientation histograms of BGR patches of one size.

    Args:
        patches: shape (n, h, w, 3).
        cell: side of a cell, px.

    Returns:
        Shape (n, 10, h // cell, w // cell), as of :func:`orientation_cells`.
    """
    return _voted(np.moveaxis(patches, -1, 1), cell)


def integral(cells: NDArray[np.int32]) -> NDArray[np.int32]:
    """Sums over all cells above and to the left: (planes, h, w) to (planes, h + 1, w + 1), int32."""
    planes, h, w = cells.shape
    out = np.zeros((planes, h + 1, w + 1), np.int32)
    _sum(cells, out)
    return out


def _voted(planes: NDArray[np.uint8], cell: int) -> NDArray[np.int32]:
    """Planes (n, channels, h, w) to histograms (n, 10, h // cell, w // cell)."""
    n, _, height, width = planes.shape
    out = np.empty((n, PLANES, height // cell, width // cell), np.int32)
    framed = np.ascontiguousarray(np.concatenate([planes[..., :1], planes, planes[..., -1:]], axis=3))
    used = width // cell * cell
    votes = np.empty(width // cell * PLANES, np.int32)  # of one row of cells, close together in memory
    _vote(framed, cell, np.empty((3, used), np.float32), np.empty((3, used), np.int32), votes, out)
    return out


# Loops process whole rows, so that the compiler can vectorise them. Sums are of whole numbers, so their order does not
# matter.
@njit(cache=True, nogil=True, error_model="numpy")
def _gradient_row(above, here, below, gx, gy, energy):  # type: ignore[no-untyped-def]
    """Takes the gradient of one channel where it is stronger than that of earlier ones; ``here`` is padded by 1 px."""
    for x in range(gx.shape[0]):
        dx = np.float32(here[x + 2]) - np.float32(here[x])
        dy = np.float32(below[x + 1]) - np.float32(above[x + 1])
        e = dx * dx + dy * dy
        stronger = e > energy[x]
        gx[x] = dx if stronger else gx[x]
        gy[x] = dy if stronger else gy[x]
        energy[x] = e if stronger else energy[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _share_row(gx, gy, energy, low, upper, whole):  # type: ignore[no-untyped-def]
    """Lower bin, vote for the bin above it, and both votes; the arc tangent is a polynomial on an octant."""
    for x in range(gx.shape[0]):
        size = np.float32(2.0) * np.sqrt(max(energy[x], np.float32(0.0)))
        ax, ay = abs(gx[x]), abs(gy[x])
        r = min(ax, ay) / (max(ax, ay) + np.float32(1e-9))
        s = r * r
        p = np.float32(0.00833) - s * np.float32(0.001865)
        p = np.float32(0.03079) + s * (np.float32(-0.0185) + s * p)
        turn = r * (np.float32(0.159154) + s * (np.float32(-0.0529) + s * p))
        turn = np.float32(0.25) - turn if ay > ax else turn
        turn = np.float32(0.5) - turn if gx[x] * gy[x] < np.float32(0.0) else turn
        place = turn * np.float32(18.0)
        k = min(np.int32(place), np.int32(8))
        low[x] = k
        whole[x] = np.int32(size + np.float32(0.5))
        upper[x] = np.int32(size * (place - np.float32(k)) + np.float32(0.5))


@njit(cache=True, nogil=True, error_model="numpy")
def _vote(patches, cell, floats, ints, votes, out):  # type: ignore[no-untyped-def]
    """Votes of patches (n, channels, h, w + 2), which have a replicated pixel at both ends of each row."""
    gx, gy, energy = floats[0], floats[1], floats[2]
    low, upper, whole = ints[0], ints[1], ints[2]
    for i in range(patches.shape[0]):
        height, columns = patches.shape[2], out.shape[3]
        for row in range(out.shape[2]):
            for v in range(votes.shape[0]):
                votes[v] = 0
            for y in range(row * cell, (row + 1) * cell):
                for x in range(energy.shape[0]):
                    energy[x] = np.float32(-1.0)
                up, down = max(y - 1, 0), min(y + 1, height - 1)
                for c in range(patches.shape[1]):
                    _gradient_row(patches[i, c, up], patches[i, c, y], patches[i, c, down], gx, gy, energy)
                _share_row(gx, gy, energy, low, upper, whole)
                for column in range(columns):  # cell by cell, to avoid a division per pixel
                    base = 10 * column
                    for x in range(column * cell, (column + 1) * cell):
                        k = low[x]
                        votes[base + k] += whole[x] - upper[x]
                        votes[base + (k + 1 if k < 8 else 0)] += upper[x]
                        votes[base + 9] += whole[x]
            for p in range(10):
                for column in range(columns):
                    out[i, p, row, column] = votes[column * 10 + p]


@njit(cache=True, nogil=True)
def _sum(cells, out):  # type: ignore[no-untyped-def]
    planes, h, w = cells.shape
    for p in range(planes):
        for y in range(h):
            total = np.int32(0)
            for x in range(w):
                total += cells[p, y, x]
                out[p, y + 1, x + 1] = out[p, y, x + 1] + total
