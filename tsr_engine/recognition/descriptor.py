"""The descriptor of a sign crop: oriented gradients and colour on one grid of cells.

A crop is resized to 48x48 px and divided into 12x12 cells of 4 px. Each cell holds 30 values:

* 18 signed and 9 unsigned orientation bins of the gradient of the square-root picture, each normalised by the four
  2x2 blocks around the cell, clipped at 0.2 and summed (Dalal & Triggs 2005; Felzenszwalb et al. 2010). The
  square root brightens dark parts and the blocks normalise local contrast, so that glare, shade and blur change
  little;
* red against green and blue against yellow, divided by the brightness, and the brightness itself against the crop's
  mean and spread.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numba as nb
import numpy as np
from numpy.typing import NDArray

from tsr_engine.records import Picture

SIDE = 48
"""Side of the resized crop, px."""
CELL = 4
"""Side of a cell, px."""
GRID = SIDE // CELL
SIGNED = 18
UNSIGNED = SIGNED // 2
CHANNELS = SIGNED + UNSIGNED + 3
"""Values of a cell: 18 signed, 9 unsigned orientations, 2 colour opponents, 1 brightness."""
LENGTH = GRID * GRID * CHANNELS
"""Values of a descriptor."""
MARGIN = 0.1
"""Border of a crop on each side of the sign, as a share of the sign's side."""

_ROOT = np.sqrt(np.arange(256, dtype=np.float64) / 255).astype(np.float32)
_ROOT.setflags(write=False)


def resize_crop(crop: Picture) -> Picture:
    """A crop of any size resized to 48x48 px: averaged if larger, interpolated if smaller.

    Raises:
        ValueError: the crop is not a BGR picture, or is empty.
    """
    if crop.ndim != 3 or crop.shape[2] != 3 or crop.dtype != np.uint8 or crop.size == 0:
        raise ValueError(f"A crop must be uint8 of shape (h, w, 3). Got {crop.dtype} {crop.shape} instead.")
    if crop.shape[:2] == (SIDE, SIDE):
        return crop
    shrinks = crop.shape[0] * crop.shape[1] > SIDE * SIDE
    resized = cv2.resize(crop, (SIDE, SIDE), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
    return np.asarray(resized, dtype=np.uint8)


def describe(crops: Sequence[Picture]) -> NDArray[np.float32]:
    """Descriptors of crops of any sizes.

    Args:
        crops: BGR, uint8; each is a sign's box plus ``MARGIN`` of its side on each side.

    Returns:
        Shape (n, 4320), float32: the cells row by row, 30 values for each. Gradient values lie in [0, 1.6], colour
        values within about 4 of 0.

    Raises:
        ValueError: a crop is not a BGR picture, or is empty.
    """
    return describe_patches(resize_crops(crops))


def resize_crops(crops: Sequence[Picture]) -> NDArray[np.uint8]:
    """Crops of any sizes as patches, shape (n, 48, 48, 3).

    Raises:
        ValueError: a crop is not a BGR picture, or is empty.
    """
    patches = np.empty((len(crops), SIDE, SIDE, 3), dtype=np.uint8)
    for patch, crop in zip(patches, crops, strict=True):
        patch[:] = resize_crop(crop)
    return patches


def describe_patches(patches: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Descriptors of crops of 48x48 px, shape (n, 48, 48, 3) -> (n, 4320).

    Raises:
        ValueError: the patches have another shape.
    """
    if patches.ndim != 4 or patches.shape[1:] != (SIDE, SIDE, 3):
        raise ValueError(f"Patches must have shape (n, {SIDE}, {SIDE}, 3). Got {patches.shape} instead.")
    out = np.empty((len(patches), GRID, GRID, CHANNELS), dtype=np.float32)
    _describe(np.ascontiguousarray(patches), _ROOT, out)
    return out.reshape(len(patches), LENGTH)


# These kernels must not reorder sums (fastmath). Freshly compiled code and code from the cache would then differ in the
# last bits, and so would the evidence of two runs.
@nb.njit(cache=True, nogil=True)
def _describe(patches, root, out):  # type: ignore[no-untyped-def]
    picture = np.empty((3, SIDE, SIDE + 2), dtype=np.float32)
    angle = np.empty((SIDE, SIDE), dtype=np.float32)
    magnitude = np.empty((SIDE, SIDE), dtype=np.float32)
    bins = np.empty((GRID + 2, GRID + 2, SIGNED + 1), dtype=np.float32)
    scale = np.empty((GRID + 1, GRID + 1), dtype=np.float32)
    for i in range(len(patches)):
        _root_planes(patches[i], root, picture)
        _gradient(picture, angle, magnitude)
        _histograms(angle, magnitude, bins)
        _normalise(bins, scale, out[i])
        _colour(patches[i], out[i])


@nb.njit(cache=True, nogil=True)
def _root_planes(patch, root, picture):  # type: ignore[no-untyped-def]
    """Square roots, (48, 48, 3) to (3, 48, 50), with one replicated pixel at both ends of a row."""
    for y in range(SIDE):
        for x in range(SIDE):
            picture[0, y, x + 1] = root[patch[y, x, 0]]
            picture[1, y, x + 1] = root[patch[y, x, 1]]
            picture[2, y, x + 1] = root[patch[y, x, 2]]
        for c in range(3):
            picture[c, y, 0], picture[c, y, SIDE + 1] = picture[c, y, 1], picture[c, y, SIDE]


@nb.njit(cache=True, nogil=True)
def _gradient(picture, angle, magnitude):  # type: ignore[no-untyped-def]
    """Gradient of the strongest colour channel: orientation in bins [0, 18) and magnitude."""
    gx, gy = np.empty(SIDE, dtype=np.float32), np.empty(SIDE, dtype=np.float32)
    for y in range(SIDE):
        energy = magnitude[y]
        energy[:] = -1
        for c in range(3):
            above, below = picture[c, max(y - 1, 0), 1:], picture[c, min(y + 1, SIDE - 1), 1:]
            _take_stronger(picture[c, y], above, below, gx, gy, energy)
        _polar_row(gx, gy, angle[y], energy)


@nb.njit(cache=True, nogil=True)
def _take_stronger(here, above, below, gx, gy, energy):  # type: ignore[no-untyped-def]
    """Takes one channel's differences where the sum of their squares exceeds ``energy``; ``here`` is padded by 1 px.

    This loop and the next have no branches, so that the compiler can vectorise them.
    """
    left, right = here[:SIDE], here[2:]
    for x in range(SIDE):
        dx, dy = right[x] - left[x], below[x] - above[x]
        m = dx * dx + dy * dy
        stronger = m > energy[x]
        gx[x] = dx if stronger else gx[x]
        gy[x] = dy if stronger else gy[x]
        energy[x] = m if stronger else energy[x]


@nb.njit(cache=True, nogil=True, error_model="numpy")
def _polar_row(gx, gy, angle, energy):  # type: ignore[no-untyped-def]
    """Computes orientations in bins, and turns energies into magnitudes."""
    for x in range(SIDE):
        angle[x] = _turn(gx[x], gy[x]) * np.float32(SIGNED)
        energy[x] = np.sqrt(energy[x])


@nb.njit(cache=True, nogil=True, inline="always", error_model="numpy")
def _turn(x, y):  # type: ignore[no-untyped-def]
    """Direction of a vector as a share of a full turn, in [0, 1), error at most 2e-5 (odd polynomial on an octant)."""
    ax, ay = abs(x), abs(y)
    steep = ay > ax
    low, high = ax if steep else ay, ay if steep else ax
    r = low / (high + np.float32(1e-12))
    s = r * r
    t = r * (
        np.float32(0.159154)
        + s
        * (
            np.float32(-0.0529)
            + s
            * (np.float32(0.03079) + s * (np.float32(-0.0185) + s * (np.float32(0.00833) - s * np.float32(0.001865))))
        )
    )
    t = np.float32(0.25) - t if steep else t
    # A comparison with an int would make Numba compute in 64 bits.
    t = np.float32(0.5) - t if x < np.float32(0) else t
    t = np.float32(1) - t if y < np.float32(0) else t
    return np.float32(0) if t >= np.float32(1) else t


@nb.njit(cache=True, nogil=True)
def _histograms(angle, magnitude, bins):  # type: ignore[no-untyped-def]
    """Adds trilinear votes; ``bins`` has a border of one cell for votes outside the grid."""
    bins[:] = 0
    for y in range(SIDE):
        cy = (y + CELL - (CELL // 2)) // CELL
        fy = (np.float32(y + CELL - CELL // 2 - cy * CELL) + np.float32(0.5)) / np.float32(CELL)
        for x in range(SIDE):
            cx = (x + CELL - (CELL // 2)) // CELL
            fx = (np.float32(x + CELL - CELL // 2 - cx * CELL) + np.float32(0.5)) / np.float32(CELL)
            o = int(angle[y, x])
            m = magnitude[y, x]
            upper = m * (angle[y, x] - np.float32(o))
            lower = m - upper
            top, bottom = np.float32(1) - fy, fy
            west, east = np.float32(1) - fx, fx
            bins[cy, cx, o] += top * west * lower
            bins[cy, cx, o + 1] += top * west * upper
            bins[cy, cx + 1, o] += top * east * lower
            bins[cy, cx + 1, o + 1] += top * east * upper
            bins[cy + 1, cx, o] += bottom * west * lower
            bins[cy + 1, cx, o + 1] += bottom * west * upper
            bins[cy + 1, cx + 1, o] += bottom * east * lower
            bins[cy + 1, cx + 1, o + 1] += bottom * east * upper
    for y in range(1, GRID + 1):
        for x in range(1, GRID + 1):
            bins[y, x, 0] += bins[y, x, SIGNED]


@nb.njit(cache=True, nogil=True)
def _normalise(bins, scale, cells):  # type: ignore[no-untyped-def]
    """Normalises each cell by its four blocks; blocks at the border repeat the nearest cells."""
    energy = np.empty((GRID, GRID), dtype=np.float32)
    for y in range(GRID):
        for x in range(GRID):
            s = np.float32(0)
            for o in range(UNSIGNED):
                v = bins[y + 1, x + 1, o] + bins[y + 1, x + 1, o + UNSIGNED]
                s += v * v
            energy[y, x] = s
    for y in range(GRID + 1):
        y0, y1 = max(y - 1, 0), min(y, GRID - 1)
        for x in range(GRID + 1):
            x0, x1 = max(x - 1, 0), min(x, GRID - 1)
            total = energy[y0, x0] + energy[y0, x1] + energy[y1, x0] + energy[y1, x1]
            scale[y, x] = np.float32(1) / math.sqrt(total + np.float32(1e-3))
    clip = np.float32(0.2)
    for y in range(GRID):
        for x in range(GRID):
            a, b, c, d = scale[y, x], scale[y, x + 1], scale[y + 1, x], scale[y + 1, x + 1]
            for o in range(SIGNED):
                v = bins[y + 1, x + 1, o]
                cells[y, x, o] = np.float32(2) * (
                    min(v * a, clip) + min(v * b, clip) + min(v * c, clip) + min(v * d, clip)
                )
            for o in range(UNSIGNED):
                v = bins[y + 1, x + 1, o] + bins[y + 1, x + 1, o + UNSIGNED]
                cells[y, x, SIGNED + o] = np.float32(2) * (
                    min(v * a, clip) + min(v * b, clip) + min(v * c, clip) + min(v * d, clip)
                )


@nb.njit(cache=True, nogil=True)
def _colour(patch, cells):  # type: ignore[no-untyped-def]
    base = SIGNED + UNSIGNED
    mean = np.float32(0)
    square = np.float32(0)
    unit = np.float32(1.0 / (255 * CELL * CELL))
    for y in range(GRID):
        for x in range(GRID):
            b = g = r = 0
            for j in range(y * CELL, (y + 1) * CELL):
                for i in range(x * CELL, (x + 1) * CELL):
                    b += patch[j, i, 0]
                    g += patch[j, i, 1]
                    r += patch[j, i, 2]
            blue, green, red = np.float32(b) * unit, np.float32(g) * unit, np.float32(r) * unit
            bright = (blue + green + red) / np.float32(3)
            cells[y, x, base] = red - green
            cells[y, x, base + 1] = blue - np.float32(0.5) * (red + green)
            cells[y, x, base + 2] = bright
            mean += bright
            square += bright * bright
    count = np.float32(GRID * GRID)
    mean /= count
    spread = math.sqrt(max(square / count - mean * mean, np.float32(0))) + np.float32(0.02)
    for y in range(GRID):
        for x in range(GRID):
            bright = cells[y, x, base + 2]
            weight = np.float32(2) / (np.float32(3) * bright + np.float32(1.5) * mean + np.float32(0.05))
            cells[y, x, base] *= weight
            cells[y, x, base + 1] *= weight
            relative = (bright - mean) / spread
            cells[y, x, base + 2] = np.float32(0.5) * max(min(relative, np.float32(2)), np.float32(-2))
