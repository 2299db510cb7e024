"""Interleaves planes of channels, cell by cell, and separates them again.

OpenCV resamples four interleaved channels in two thirds of the time of four planes, with the same bits. It is slow for
more than four. The scan needs planes.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.scratch import Scratch
from tsr_engine.channels.smooth import replicate
from tsr_engine.kernels import kernel

MAX_INTERLEAVED = 4
"""Largest number of interleaved channels."""


def interleave(cells: NDArray[np.uint8], border: int = 0, scratch: Scratch | None = None) -> list[NDArray[np.uint8]]:
    """Interleave channels in groups of ``MAX_INTERLEAVED``.

    Args:
        cells: shape (channels, h + 2 border, w + 2 border), uint8.
        border: number of cells to leave out on each side.
        scratch: memory for the result; unset: new memory.

    Returns:
        Arrays of shape (h, w, up to 4) with the channels in order.
    """
    scratch, (channels, height, width) = scratch or Scratch(), cells.shape
    interleaved = []
    for first in range(0, channels, MAX_INTERLEAVED):
        planes = list(cells[first : first + MAX_INTERLEAVED])
        buffer = scratch.array(f"packed from {first}", (height, width, len(planes)), np.uint8)
        # This includes the border: planes without gaps between their rows make it four times as fast.
        cv2.merge(planes, dst=buffer)
        interleaved.append(buffer[border : height - border, border : width - border])
    return interleaved


@kernel()
def deinterleave(packed, planes, border):  # type: ignore[no-untyped-def]
    """Separates interleaved channels into planes and replicates ``border`` cells on each side.

    ``cv2.split`` can do the first step. For planes with gaps between their rows it takes eight times as long at some
    widths.

    Args:
        packed: shape (channels * h * w,), uint8: the arrays of :func:`interleave`, (h, w, up to 4) each, one after
            another.
        planes: shape (channels, h + 2 border, w + 2 border), uint8; receives the result.
        border: number of cells.
    """
    channels, height, width = planes.shape
    rows, columns = height - 2 * border, width - 2 * border
    for first in range(0, channels, MAX_INTERLEAVED):
        count = min(MAX_INTERLEAVED, channels - first)
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


# With a fixed number of channels, the compiler turns these loops into vector shuffles.
@kernel()
def _four(row, a, b, c, d):  # type: ignore[no-untyped-def]
    for x in range(a.shape[0]):
        a[x], b[x], c[x], d[x] = row[4 * x], row[4 * x + 1], row[4 * x + 2], row[4 * x + 3]


@kernel()
def _two(row, a, b):  # type: ignore[no-untyped-def]
    for x in range(a.shape[0]):
        a[x], b[x] = row[2 * x], row[2 * x + 1]
