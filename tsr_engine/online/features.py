"""The descriptor of the online detector and its response over all windows of a search region.

A region is resampled once so that the window has ``SIDE`` px; its channels are averaged over cells of ``CELL`` px
at every position, and a descriptor is 6x6 cells of the nine channels L, U, V and six orientations (d = 324),
scaled to unit length. So the decision values of a linear SVM over all windows are a correlation of the cell maps with
the weights, divided by the windows' norms.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.channels.compute import compute_channels
from tsr_engine.geometry.boxes import to_cxcywh, to_xyxy
from tsr_engine.protocols import PixelSource
from tsr_engine.records import FloatArray, Picture

CELL = 4
"""Side of a cell in window px."""
CELLS = 6
"""Cells along each side of the window."""
SIDE = CELL * CELLS
"""Side of the window, px of the resampled region."""
FEATURES = CELLS * CELLS * 9
"""Length of a descriptor."""
MARGIN = 0.05
"""Border of the window around the box, as a share of the box's side: the contrast of a sign's rim needs background."""
PAD = 5
"""Border of the resampled region around the outermost window, px, for the channels' normalisation."""

_PLANES = (0, 1, 2, 4, 5, 6, 7, 8, 9)
_CENTRE = np.array([0.4, 0.33, 0.5] + [0.0] * 6, dtype=np.float32)


@dataclass(frozen=True, slots=True)
class WindowGrid:
    """Positions of windows of one size over a search region.

    Attributes:
        centre: shape (2,), centre of the prediction, frame px.
        pitch: shape (2,), frame px per window px (x, y).
        reach: number of windows on each side of the middle one (x, y).
    """

    centre: FloatArray
    pitch: FloatArray
    reach: tuple[int, int]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the resampled region."""
        return tuple(SIDE + 2 * (k + PAD) for k in self.reach)  # type: ignore[return-value]

    @property
    def extent(self) -> FloatArray:
        """The region in the frame, shape (4,)."""
        half = self.pitch * np.array(self.size) / 2.0
        return np.concatenate([self.centre - half, self.centre + half])

    def box(self, column: float, row: float) -> FloatArray:
        """The box, shape (4,), of the window at a place of the response map; the middle one is at ``reach``."""
        offset = (np.array([column, row]) - np.array(self.reach)) * self.pitch
        size = self.pitch * SIDE / (1.0 + 2.0 * MARGIN)
        return to_xyxy(np.concatenate([self.centre + offset, size]))


def make_grid(box: FloatArray, radius: float, scale: float = 1.0) -> WindowGrid:
    """The windows of one size around a box, at most ``radius`` frame px away along each axis.

    Neighbouring windows are one window px apart, about 1/22 of the box's side.
    """
    cx, cy, w, h = to_cxcywh(box)
    pitch = np.array([w, h]) * scale * (1.0 + 2.0 * MARGIN) / SIDE
    reach = np.floor(radius / pitch + 1e-9).astype(int)
    return WindowGrid(np.array([cx, cy]), pitch, (int(reach[0]), int(reach[1])))


def pixel_extent(extent: FloatArray) -> tuple[int, int, int, int]:
    """Bounds ``x1, y1, x2, y2`` of all pixels that sampling inside an extent (4,) may read."""
    x1, y1 = np.floor(extent[:2]).astype(int) - 1
    x2, y2 = np.ceil(extent[2:]).astype(int) + 1
    return int(x1), int(y1), int(x2), int(y2)


def cell_maps(picture: Picture, origin: tuple[int, int], grid: WindowGrid) -> NDArray[np.float32]:
    """Cell means at every position of the resampled region.

    Args:
        picture: pixels that cover ``grid.extent``.
        origin: frame coordinates of the picture's top-left pixel.
        grid: the windows.

    Returns:
        Shape (9, H, W), float32: ``[c, y, x]`` is the mean of channel c over the cell whose top-left px is (x, y).
    """
    qx, qy = grid.pitch
    smooth = picture
    if max(qx, qy) > 1.5:
        smooth = cv2.GaussianBlur(picture, (0, 0), sigmaX=0.4 * qx, sigmaY=0.4 * qy, borderType=cv2.BORDER_REPLICATE)
    left, top = grid.extent[:2] - np.array(origin)
    # Pixel centres: window px (u, v) lies at frame px left + (u + 1/2) q - 1/2.
    matrix = np.array([[qx, 0.0, left + 0.5 * qx - 0.5], [0.0, qy, top + 0.5 * qy - 0.5]])
    region = cv2.warpAffine(
        smooth, matrix, grid.size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE
    )
    channels = compute_channels(np.ascontiguousarray(region, dtype=np.uint8), shrink=1)
    maps = np.empty((9, *channels.shape[1:]), dtype=np.float32)
    for target, plane in enumerate(_PLANES):
        cv2.boxFilter(
            channels[plane] - _CENTRE[target],
            -1,
            (CELL, CELL),
            dst=maps[target],
            anchor=(0, 0),
            borderType=cv2.BORDER_REPLICATE,
        )
    return maps


@njit(cache=True, nogil=True)
def score_windows(
    maps: NDArray[np.float32], weights: NDArray[np.float32], offset: float, pad: int, out: NDArray[np.float32]
) -> None:
    """Decision values of all windows.

    Args:
        maps: shape (9, H, W) from :func:`cell_maps`.
        weights: shape (9, 6, 6).
        offset: the SVM's offset b.
        pad: position of the first window.
        out: shape (windows down, windows across); receives the values.
    """
    rows, columns = out.shape
    planes, cells, _ = weights.shape
    energy = np.zeros(maps.shape[1:], dtype=np.float32)
    for c in range(planes):
        for y in range(maps.shape[1]):
            target, source = energy[y], maps[c, y]
            for x in range(len(target)):
                target[x] += source[x] * source[x]
    norms = np.empty(columns, dtype=np.float32)
    for y in range(rows):
        total = out[y]
        total[:] = 0.0
        norms[:] = 1e-12
        for i in range(cells):
            v = pad + y + i * CELL
            for j in range(cells):
                u = pad + j * CELL
                squares = energy[v, u : u + columns]
                for x in range(columns):
                    norms[x] += squares[x]
                for c in range(0, planes, 3):
                    # Each pass adds three planes, so that the total is loaded and stored less often.
                    w0, w1, w2 = weights[c, i, j], weights[c + 1, i, j], weights[c + 2, i, j]
                    m0 = maps[c, v, u : u + columns]
                    m1 = maps[c + 1, v, u : u + columns]
                    m2 = maps[c + 2, v, u : u + columns]
                    for x in range(columns):
                        total[x] += w0 * m0[x] + w1 * m1[x] + w2 * m2[x]
        for x in range(columns):
            total[x] = total[x] / np.sqrt(norms[x]) + np.float32(offset)


def descriptor_at(maps: NDArray[np.float32], row: int, column: int) -> FloatArray:
    """The descriptor of one window of the maps, shape (324,), float64, unit length."""
    y, x = PAD + row, PAD + column
    cells = maps[:, y : y + SIDE : CELL, x : x + SIDE : CELL].astype(np.float64).ravel()
    return np.asarray(cells / np.sqrt((cells**2).sum() + 1e-12))


def describe(pixels: PixelSource, box: FloatArray) -> FloatArray:
    """The descriptor of one box (4,) of a frame, shape (324,), float64, unit length.

    Raises:
        ValueError: the box is not finite or smaller than 1x1 px.
    """
    check_box(box)
    grid = make_grid(box, 0.0)
    x1, y1, x2, y2 = pixel_extent(grid.extent)
    return descriptor_at(cell_maps(pixels.crop(x1, y1, x2, y2), (x1, y1), grid), 0, 0)


def describe_with_neighbours(
    pixels: PixelSource, box: FloatArray, offsets: list[tuple[int, int]]
) -> tuple[FloatArray, list[FloatArray]]:
    """Descriptors of a box and of windows of its size around it, from one crop of the frame.

    Args:
        pixels: the frame.
        box: shape (4,).
        offsets: displacements (x, y) of m windows, in window px.

    Returns:
        Descriptors, shape (1 + m, 324), that of the box first; and the boxes of the m windows.

    Raises:
        ValueError: the box is not finite or smaller than 1x1 px.
    """
    check_box(box)
    centre_grid = make_grid(box, 0.0)
    reach = max((abs(v) for offset in offsets for v in offset), default=0)
    grid = WindowGrid(centre_grid.centre, centre_grid.pitch, (reach, reach))
    x1, y1, x2, y2 = pixel_extent(grid.extent)
    maps = cell_maps(pixels.crop(x1, y1, x2, y2), (x1, y1), grid)
    rows = [descriptor_at(maps, reach + y, reach + x) for x, y in [(0, 0), *offsets]]
    return np.stack(rows), [grid.box(float(reach + x), float(reach + y)) for x, y in offsets]


def check_box(box: FloatArray) -> None:
    """Check that a box is finite and at least 1x1 px.

    Raises:
        ValueError: it is not.
    """
    if np.shape(box) != (4,) or not np.isfinite(box).all() or box[2] - box[0] < 1.0 or box[3] - box[1] < 1.0:
        raise ValueError(f"A box must be finite x1, y1, x2, y2 of at least 1x1 px. Got {box} instead.")
