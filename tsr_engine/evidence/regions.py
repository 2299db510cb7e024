"""Supplies pixels on request, from the frame itself or from stored rectangles of it.

Both give the same crops bit by bit, so a replay gets the pixels of the run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from tsr_engine.records import Picture, Region

Rectangle = tuple[int, int, int, int]
"""``x1, y1, x2, y2`` in whole pixels, inside the frame, not empty."""


class FramePixels:
    """Crops one frame, and records the requested rectangles.

    Args:
        picture: BGR, uint8, shape (height, width, 3); not copied.
    """

    def __init__(self, picture: Picture) -> None:
        self._picture = picture
        self.height, self.width = picture.shape[:2]
        self._requested: dict[Rectangle, None] = {}

    def crop(self, x1: int, y1: int, x2: int, y2: int) -> Picture:
        """The BGR pixels of ``[x1, x2) x [y1, y2)``; beyond the frame the border is replicated.

        A request without area gives an empty picture and is not recorded.
        """
        if x2 <= x1 or y2 <= y1:
            return np.zeros((max(0, y2 - y1), max(0, x2 - x1), 3), np.uint8)
        inner = _inside(x1, y1, x2, y2, self.width, self.height)
        self._requested[inner] = None
        pixels = self._picture[inner[1] : inner[3], inner[0] : inner[2]]
        return _replicate(pixels, inner, x1, y1, x2, y2)

    def regions(self, pad: int = 0) -> tuple[Region, ...]:
        """Copies of all requested pixels, in few rectangles.

        Args:
            pad: px added around each request, so that a replay may search a little further.
        """
        grown = [
            (max(0, x1 - pad), max(0, y1 - pad), min(self.width, x2 + pad), min(self.height, y2 + pad))
            for x1, y1, x2, y2 in self._requested
        ]
        return tuple(
            Region(x1, y1, np.ascontiguousarray(self._picture[y1:y2, x1:x2])) for x1, y1, x2, y2 in merge(grown)
        )


class StoredPixels:
    """Crops a frame of which only some rectangles are stored.

    Args:
        width: frame width, px.
        height: frame height, px.
        regions: the rectangles; where they overlap, the later one is used.

    Attributes:
        missing: number of frame pixels that crops needed and no region has, counted for each crop. They are
            filled with the nearest stored pixel (black without any region).
    """

    def __init__(self, width: int, height: int, regions: Sequence[Region]) -> None:
        self.width = width
        self.height = height
        self.missing = 0
        self._regions = tuple(regions)

    def crop(self, x1: int, y1: int, x2: int, y2: int) -> Picture:
        """The BGR pixels of ``[x1, x2) x [y1, y2)``; beyond the frame the border is replicated."""
        if x2 <= x1 or y2 <= y1:
            return np.zeros((max(0, y2 - y1), max(0, x2 - x1), 3), np.uint8)
        inner = left, top, right, bottom = _inside(x1, y1, x2, y2, self.width, self.height)
        pixels = np.zeros((bottom - top, right - left, 3), np.uint8)
        known = np.zeros(pixels.shape[:2], np.bool_)
        for region in self._regions:
            h, w = region.pixels.shape[:2]
            a, b = max(left, region.x), min(right, region.x + w)
            c, d = max(top, region.y), min(bottom, region.y + h)
            if a < b and c < d:
                part = region.pixels[c - region.y : d - region.y, a - region.x : b - region.x]
                pixels[c - top : d - top, a - left : b - left] = part
                known[c - top : d - top, a - left : b - left] = True
        if not known.all():
            self._fill(pixels, ~known, left, top)
        return _replicate(pixels, inner, x1, y1, x2, y2)

    def _fill(self, pixels: Picture, unknown: NDArray[np.bool_], left: int, top: int) -> None:
        ys, xs = np.nonzero(unknown)
        self.missing += len(ys)
        nearest = np.full(len(ys), np.inf)
        fill = np.zeros((len(ys), 3), np.uint8)
        for region in self._regions:
            h, w = region.pixels.shape[:2]
            column = np.clip(xs + left - region.x, 0, w - 1)
            row = np.clip(ys + top - region.y, 0, h - 1)
            distance = np.hypot(xs + left - region.x - column, ys + top - region.y - row)
            # "<=": of two equally near regions the later one is used, as where they overlap.
            closer = distance <= nearest
            nearest[closer] = distance[closer]
            fill[closer] = region.pixels[row[closer], column[closer]]
        pixels[ys, xs] = fill


def merge(rectangles: Iterable[Rectangle]) -> list[Rectangle]:
    """Replace rectangles by fewer ones that cover the same pixels.

    Two are replaced by their bounding box if that has no more pixels than both together. The remaining ones may
    overlap a little; storing the overlap twice is cheaper than the bounding box.
    """
    merged: list[Rectangle] = []
    for rectangle in sorted(set(rectangles)):
        candidate = rectangle
        while True:
            partner = next((other for other in merged if _worth_merging(candidate, other)), None)
            if partner is None:
                break
            merged.remove(partner)
            candidate = _bounding(candidate, partner)
        merged.append(candidate)
    return sorted(merged)


def _worth_merging(a: Rectangle, b: Rectangle) -> bool:
    return _area(_bounding(a, b)) <= _area(a) + _area(b)


def _bounding(a: Rectangle, b: Rectangle) -> Rectangle:
    return min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3])


def _area(a: Rectangle) -> int:
    return (a[2] - a[0]) * (a[3] - a[1])


def _inside(x1: int, y1: int, x2: int, y2: int, width: int, height: int) -> Rectangle:
    """The pixels of the frame that a crop needs: at least the nearest border pixels."""
    left, top = min(max(int(x1), 0), width - 1), min(max(int(y1), 0), height - 1)
    right, bottom = max(min(int(x2), width), 1), max(min(int(y2), height), 1)
    return left, top, max(right, left + 1), max(bottom, top + 1)


def _replicate(pixels: Picture, inner: Rectangle, x1: int, y1: int, x2: int, y2: int) -> Picture:
    """The pixels of ``inner``, extended to the requested rectangle by repeating its outermost rows and columns."""
    if inner == (x1, y1, x2, y2):
        return np.ascontiguousarray(pixels)
    columns = np.clip(np.arange(x1, x2), inner[0], inner[2] - 1) - inner[0]
    rows = np.clip(np.arange(y1, y2), inner[1], inner[3] - 1) - inner[1]
    return np.ascontiguousarray(pixels[rows[:, None], columns[None, :]])
