"""Classifier of the proposals of [20] of the paper: a HOG with colour, and one linear SVM for each family of signs.

The descriptor is that of Dalal and Triggs: a patch of 48 px, cells of 6 px, blocks of 2 x 2 cells with their L2 norm
clipped at 0.2, gradients of the strongest colour channel; and the mean of every colour map in every cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.systems.colour_model import COLOURS
from benchmarks.systems.hog import BINS, patch_cells
from tsr_engine.records import FloatArray, Picture

SIDE: Final = 48
"""Side of the patch, px."""
CELL: Final = 6
GRID: Final = SIDE // CELL
MARGIN: Final = 0.12
"""Border of the patch around the box, as a share of the box's side."""
LENGTH: Final = (GRID - 1) ** 2 * 4 * BINS + GRID * GRID * len(COLOURS)
"""Values of a descriptor."""

FAMILIES: Final[dict[str, frozenset[int]]] = {
    "prohibitory": frozenset((*range(6), 7, 8, 9, 10, 15, 16, 17)),
    "danger": frozenset((11, *range(18, 32))),
    "mandatory": frozenset(range(33, 41)),
    "ends of limits": frozenset((6, 32, 41, 42)),
    "right of way": frozenset((12, 13, 14)),
}
"""Families of classes by shape and colour; each of the 43 classes is in one."""


@dataclass(frozen=True, slots=True)
class HogSvm:
    """One linear SVM for each family.

    Attributes:
        weights: shape (families, LENGTH), float32.
        offsets: shape (families,).
    """

    weights: NDArray[np.float32]
    offsets: NDArray[np.float32]

    def scores(self, descriptors: NDArray[np.float32]) -> FloatArray:
        """The highest decision value of any family, (n, LENGTH) to (n,)."""
        if not len(descriptors):
            return np.zeros(0)
        return np.asarray((descriptors @ self.weights.T + self.offsets).max(axis=1), dtype=np.float64)


def describe_boxes(picture: Picture, maps: NDArray[np.uint8], boxes: FloatArray) -> NDArray[np.float32]:
    """Descriptors of boxes of a picture.

    Args:
        picture: BGR.
        maps: colour maps of the picture, (colours, h, w).
        boxes: shape (n, 4), px; the picture's border is replicated beyond its edges.

    Returns:
        Shape (n, LENGTH), in [0, 0.3].
    """
    patches = np.empty((len(boxes), SIDE, SIDE, 3), np.uint8)
    colours = np.empty((len(boxes), GRID, GRID, len(COLOURS)), np.uint8)
    together = np.ascontiguousarray(np.moveaxis(maps, 0, -1))
    for i, box in enumerate(boxes):
        inside = _surroundings(box)
        shrinks = (inside[1] - inside[0]) * (inside[3] - inside[2]) > SIDE * SIDE
        method = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        patches[i] = cv2.resize(_cut(picture, inside), (SIDE, SIDE), interpolation=method)
        colours[i] = cv2.resize(_cut(together, inside), (GRID, GRID), interpolation=cv2.INTER_AREA)
    n = len(boxes)
    cells = patch_cells(patches, CELL)[:, :BINS].astype(np.float32)
    blocks = np.concatenate([cells[:, :, y : y + GRID - 1, x : x + GRID - 1] for y in (0, 1) for x in (0, 1)], axis=1)
    for _ in range(2):  # L2, clip, L2 again
        blocks /= np.sqrt((blocks**2).sum(axis=1, keepdims=True) + np.float32(1e-3))
        np.minimum(blocks, np.float32(0.2), out=blocks)
    colour = colours.astype(np.float32).reshape(n, GRID * GRID * len(COLOURS)) * np.float32(0.3 / 255)
    return np.concatenate([blocks.reshape(n, 4 * BINS * (GRID - 1) ** 2), colour], axis=1)


def _surroundings(box: FloatArray) -> tuple[int, int, int, int]:
    """Bounds ``top, bottom, left, right``, whole px, of a box with its margin; at least one pixel wide and high."""
    w, h = box[2] - box[0], box[3] - box[1]
    left, right = round(box[0] - MARGIN * w), round(box[2] + MARGIN * w)
    top, bottom = round(box[1] - MARGIN * h), round(box[3] + MARGIN * h)
    return top, max(bottom, top + 1), left, max(right, left + 1)


def _cut(picture: NDArray[np.uint8], inside: tuple[int, int, int, int]) -> NDArray[np.uint8]:
    top, bottom, left, right = inside
    height, width = picture.shape[:2]
    if top >= 0 and left >= 0 and bottom <= height and right <= width:
        return picture[top:bottom, left:right]
    rows = np.clip(np.arange(top, bottom), 0, height - 1)
    columns = np.clip(np.arange(left, right), 0, width - 1)
    return picture[rows[:, None], columns[None]]
