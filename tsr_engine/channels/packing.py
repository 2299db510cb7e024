"""Planes of channels laid side by side, cell by cell, and back.

OpenCV resamples four interleaved channels in two thirds of the time of four planes, to the same bits. More than four at
once take a slow path. The scan needs planes.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.channels.scratch import Scratch
from tsr_engine.channels.smooth import replicate

TOGETHER = 4
"""Most channels side by side."""


def pack(cells: NDArray[np.uint8], border: int = 0, scratch: Scratch | None = None) -> list[NDArray[np.uint8]]:
    """Channels interleaved, ``TOGETHER`` at a time.

    Args:
        cells: shape (channels, h + 2 border, w + 2 border), uint8.
        border: cells that are left out on each side.
        scratch: memory of the result; unset: new.

    Returns:
        Arrays of shape (h, w, up to 4), which hold the channels in order.
    """
    scratch, (channels, height, width) = scratch or Scratch(), cells.shape
    packed = []
    for first in range(0, channels, TOGETHER):
        planes = list(cells[first : first + TOGETHER])
        room = scratch.array(f"packed from {first}", (height, width, len(planes)), np.uint8)
        # the border as well: whole planes lie without gaps, which makes this four times as fast
        cv2.merge(planes, dst=room)
        packed.append(room[border : height - border, border : width - border])
    return packed


@njit(cache=True, nogil=True, error_model="numpy")
def unpack(packed, planes, border):  # type: ignore[no-untyped-def]
    """Lays interleaved channels into planes and replicates them ``border`` cells beyond each side.

    ``cv2.split`` does the first, but for planes with gaps between their rows it takes, at some widths, eight times as
    long.

    Args:
        packed: the arrays of :func:`pack`, (h, w, up to 4) each, behind each other in one, (channels * h * w,), uint8.
        planes: shape (channels, h + 2 border, w + 2 border), uint8: where to write.
        border: cells.
    """
    channels, height, width = planes.shape
    rows, columns = height - 2 * border, width - 2 * border
    for first in range(0, channels, TOGETHER):
        count = min(TOGETHER, channels - first)
        for y in range(rows):
            start = first * rows * columns + y * columns * count
            row = packed[start : start + columns * count]
            target = planes[first : first + count, y + border, border : width - border]
            if count == 4:
                _four(row, target[0], target[1], target[2], target[3])
            elif count == 2:
                _two(row, target[0], target[1])
            else:
                for c in range(count):
                    for x in range(columns):
                        target[c, x] = row[count * x + c]
    replicate(planes, border)


# With a fixed number of channels the loops become shuffles of whole vectors.
@njit(cache=True, nogil=True, error_model="numpy")
def _four(row, a, b, c, d):  # type: ignore[no-untyped-def]
    for x in range(a.shape[0]):
        a[x], b[x], c[x], d[x] = row[4 * x], row[4 * x + 1], row[4 * x + 2], row[4 * x + 3]


@njit(cache=True, nogil=True, error_model="numpy")
def _two(row, a, b):  # type: ignore[no-untyped-def]
    for x in range(a.shape[0]):
        a[x], b[x] = row[2 * x], row[2 * x + 1]
