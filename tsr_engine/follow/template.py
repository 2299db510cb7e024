"""Templates: the appearance of a sign in one frame, at any size up to the original."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.patch import cut_patch
from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.records import FloatArray, Picture

LEVELS: Final = (8.0, 9.5, 11.3, 13.5, 16.0, 19.0, 22.6, 27.0, 32.0)
"""Sizes (root of a box's area) at which pictures are compared, px."""
_BORDER_SHARE: Final = 0.08
"""Border around the box that is compared as well, as a share of its size: a sign's edge needs background."""
_CORNER_WEIGHT: Final = 0.1
_STORED_RESOLUTION: Final = 2.0
"""Largest resolution of stored pixels, as a multiple of the largest level."""


def size_of(box: FloatArray) -> float:
    """Root of a box's area, px."""
    return math.sqrt(max((box[2] - box[0]) * (box[3] - box[1]), 1e-6))


def level_below(size: float) -> float:
    """The largest level that is not above a size; the smallest if all are."""
    return max((level for level in LEVELS if level <= size * 1.02), default=LEVELS[0])


@dataclass(frozen=True, slots=True)
class View:
    """A square cut-out of a picture in which a box has a given size.

    Attributes:
        pixels: shape (side, side, 3), float32, with the box in the middle.
        centre: centre of the box in the picture, shape (2,), px.
        scale: px of the cut-out per px of the picture.
    """

    pixels: NDArray[np.float32]
    centre: FloatArray
    scale: float

    @property
    def middle(self) -> float:
        """Position of the box's centre in the cut-out, in pixel-centre coordinates."""
        return (len(self.pixels) - 1) / 2.0


def view(picture: Picture, box: FloatArray, level: float, reach: float) -> View:
    """Cut out a box and its surroundings.

    Args:
        picture: BGR, uint8.
        box: shape (4,), px.
        level: size of the box in the cut-out, px.
        reach: border around the box's longer side, px of the cut-out.
    """
    centre = to_cxcywh(box)
    size = size_of(box)
    side = 2 * math.ceil(reach + 0.5 * level / size * max(centre[2], centre[3]))
    pixels = cut_patch(picture, box, level, side).astype(np.float32)
    return View(pixels, centre[:2], level / size)


@dataclass(slots=True, eq=False)
class Template:
    """The appearance of the sign in one frame.

    Attributes:
        box: shape (4,), px, box of the sign in that frame.
        variance: variance of the natural logarithm of the box's size; 0 for an anchor.
        anchor: whether a person drew the box.
    """

    box: FloatArray
    variance: float
    anchor: bool
    size: float
    _picture: Picture
    _stored_box: FloatArray
    _picture_edges: FloatArray
    _cache: dict[float, tuple[NDArray[np.float32], NDArray[np.float32]]] = field(default_factory=dict)

    @classmethod
    def cut(cls, picture: Picture, box: FloatArray, variance: float, anchor: bool) -> Template:
        """Make a template from a picture and a box (4,); pixels beyond the picture's edge get no weight."""
        size = size_of(box)
        level = min(size, _STORED_RESOLUTION * LEVELS[-1])
        longer = max(box[2] - box[0], box[3] - box[1]) * level / size
        side = 2 * math.ceil(0.5 * longer + 0.3 * level + 2)
        stored = cut_patch(picture, box, level, side)
        # The box in coordinates of the stored pixels; the picture's edges follow from it.
        half = (box[2:] - box[:2]) * level / size / 2.0
        stored_box = np.concatenate([side / 2.0 - half, side / 2.0 + half])
        height, width = picture.shape[:2]
        picture_edges = (np.array([0.0, 0.0, width, height]) - np.tile(to_cxcywh(box)[:2], 2)) * level / size
        return cls(box.copy(), variance, anchor, size, stored, stored_box, picture_edges)

    def at_level(self, level: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Pixels (h, w, 3) and weights (h, w) at a level, with the box in the middle."""
        cached = self._cache.get(level)
        if cached is None:
            cached = self._cache[level] = self._cut_weighted(level)
        return cached

    def _sides(self, level: float) -> FloatArray:
        sides: FloatArray = (self._stored_box[2:] - self._stored_box[:2]) / size_of(self._stored_box) * level
        return sides

    def _cut_weighted(self, level: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        width, height = self._sides(level)
        border = max(_BORDER_SHARE * level, 1.0)
        pixels = self._cut(level, math.ceil(width + 2.0 * border), math.ceil(height + 2.0 * border))
        h, w = pixels.shape[:2]
        x = (np.arange(w) - (w - 1) / 2.0)[None, :] / (width / 2.0 + 0.5 * border)
        y = (np.arange(h) - (h - 1) / 2.0)[:, None] / (height / 2.0 + 0.5 * border)
        weights = np.where(x**2 + y**2 < 1.0, 1.0, _CORNER_WEIGHT)
        left, top, right, bottom = self._picture_edges * level / size_of(self._stored_box)
        across, down = np.arange(w) - (w - 1) / 2.0, np.arange(h) - (h - 1) / 2.0
        weights *= ((across > left) & (across < right))[None, :] & ((down > top) & (down < bottom))[:, None]
        return pixels, weights.astype(np.float32)

    def _cut(self, level: float, w: int, h: int) -> NDArray[np.float32]:
        # Both sides must be odd, or both even, so that their middle is that of one square cut-out.
        h += (w - h) % 2
        side = max(w, h)
        square = cut_patch(self._picture, self._stored_box, level, side)
        top, left = (side - h) // 2, (side - w) // 2
        return np.ascontiguousarray(square[top : top + h, left : left + w], dtype=np.float32)
