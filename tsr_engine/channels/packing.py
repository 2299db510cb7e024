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


def unpack(part: NDArray[np.uint8], planes: NDArray[np.uint8], border: int = 0) -> None:
    """Lays interleaved channels into the inner part of planes.

    ``cv2.split`` does the same, but for planes with gaps between their rows it takes, at some widths, eight times as
    long.

    Args:
        part: shape (h, w, n), contiguous.
        planes: shape (n, h + 2 border, w + 2 border), uint8: where to write.
        border: cells on each side that stay as they are.
    """
    height, width, count = part.shape
    _unpack(part.reshape(height, width * count), planes, border)


@njit(cache=True, nogil=True, error_model="numpy")
def _unpack(rows, planes, border):  # type: ignore[no-untyped-def]
    count, _, columns = planes.shape
    for y in range(rows.shape[0]):
        row, target = rows[y], planes[:, y + border, border : columns - border]
        if count == 4:
            _four(row, target[0], target[1], target[2], target[3])
        elif count == 2:
            _two(row, target[0], target[1])
        else:
            for c in range(count):
                for x in range(target.shape[1]):
                    target[c, x] = row[count * x + c]


# With a fixed number of channels the loops become shuffles of whole vectors.
@njit(cache=True, nogil=True, error_model="numpy")
def _four(row, a, b, c, d):  # type: ignore[no-untyped-def]
    for x in range(a.shape[0]):
        a[x], b[x], c[x], d[x] = row[4 * x], row[4 * x + 1], row[4 * x + 2], row[4 * x + 3]


@njit(cache=True, nogil=True, error_model="numpy")
def _two(row, a, b):  # type: ignore[no-untyped-def]
    for x in range(a.shape[0]):
        a[x], b[x] = row[2 * x], row[2 * x + 1]
