"""The 43 signs of GTSRB drawn as vectors in the German manner, at any resolution, with their silhouettes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tsr_engine.pictograms import figures as pic
from tsr_engine.pictograms.canvas import Canvas, Colour, Points, arc, regular, rounded
from tsr_engine.pictograms.glyphs import write

N_CLASSES = 43
"""Number of classes of GTSRB."""

BLUE: Colour = (12, 72, 150)
YELLOW: Colour = (246, 190, 16)
GREY: Colour = (120, 122, 124)

_LIMITS = {0: "20", 1: "30", 2: "50", 3: "60", 4: "70", 5: "80", 7: "100", 8: "120"}
_WARNINGS: dict[int, Callable[[Canvas], None]] = {
    11: pic.crossing_priority,
    18: pic.exclamation,
    19: partial(pic.bend, right=False),
    20: partial(pic.bend, right=True),
    21: pic.double_bend,
    22: pic.bumps,
    23: pic.skid,
    24: pic.narrows,
    25: pic.roadworks,
    26: pic.lights,
    27: pic.pedestrian,
    28: pic.children,
    29: pic.bicycle,
    30: pic.snowflake,
    31: pic.deer,
}
_MANDATORY: dict[int, Callable[[Canvas], None]] = {
    33: partial(pic.turn_ahead, right=True),
    34: partial(pic.turn_ahead, right=False),
    35: pic.straight,
    36: partial(pic.straight_or, right=True),
    37: partial(pic.straight_or, right=False),
    38: partial(pic.keep, right=True),
    39: partial(pic.keep, right=False),
    40: pic.circling,
}


def _triangle(radius: float, corner: float, *, up: bool) -> Points:
    """A rounded equilateral triangle of a circumradius, centred in its box."""
    sign = -1 if up else 1
    corners = regular(3, radius, -90 if up else 90)
    return np.asarray(rounded(corners, corner) + np.array([0.0, -sign * np.sqrt(3) / 6]))


def outline(class_id: int) -> Points:
    """The silhouette of a sign.

    Args:
        class_id: GTSRB class, 0 to 42.

    Returns:
        (n, 2) polygon within [-1, 1] x [-1, 1], y down; the unit is half the sign's nominal width.

    Raises:
        ValueError: The class is not one of the 43.
    """
    if not 0 <= class_id < N_CLASSES:
        raise ValueError(f"class_id must be within 0 to {N_CLASSES - 1}, got {class_id}: take a GTSRB class.")
    if class_id in _WARNINGS:
        return _triangle(2 / np.sqrt(3), 0.1, up=True)
    if class_id == 13:
        return _triangle(2 / np.sqrt(3), 0.1, up=False)
    if class_id == 12:
        return rounded(regular(4, 1.03, 0), 0.08)
    if class_id == 14:
        return rounded(regular(8, 1 / np.cos(np.pi / 8), 22.5), 0.06)
    return arc(0, 0, 1, 1, 0, 360, 181)[:-1]


def nominal_width(class_id: int) -> float:
    """Width of the sign of the usual size, in metres; the unit of `outline` is half of it."""
    if class_id in _WARNINGS or class_id in (13, 14):
        return 0.9
    return 0.84 if class_id == 12 else 0.75 if class_id in (7, 8) else 0.6


def _red_ring(canvas: Canvas) -> None:
    canvas.disc(0, 0, 1.1, pic.WHITE)
    canvas.disc(0, 0, 0.955, pic.RED)
    canvas.disc(0, 0, 0.735, pic.WHITE)


def _limit(canvas: Canvas, text: str, colour: Colour = pic.BLACK) -> None:
    three = len(text) == 3
    write(canvas, text, 0.66 if three else 0.76, 0, 0.01, colour, 0.8 if three else 1.0)


def _end(canvas: Canvas) -> None:
    """Black bars from lower left to upper right, within a thin dark ring."""
    across = np.array([1.0, 1.0]) / np.sqrt(2)
    along = np.array([1.0, -1.0]) / np.sqrt(2)
    for k in (-2, -1, 0, 1, 2):
        shift = across * 0.095 * k
        reach = np.sqrt(0.93**2 - (0.095 * k) ** 2)
        canvas.stroke(np.stack([shift - along * reach, shift + along * reach]), 0.052, pic.BLACK)


def _end_base(canvas: Canvas) -> None:
    canvas.disc(0, 0, 1.1, pic.WHITE)
    canvas.disc(0, 0, 0.975, pic.BLACK)
    canvas.disc(0, 0, 0.93, pic.WHITE)


def _warning(canvas: Canvas, symbol: Callable[[Canvas], None]) -> None:
    canvas.fill(np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float), pic.WHITE)
    canvas.fill(_triangle(1.07, 0.08, up=True), pic.RED)
    canvas.fill(_triangle(0.765, 0.05, up=True), pic.WHITE)
    symbol(canvas)


def _special(canvas: Canvas, class_id: int) -> None:
    """The signs that belong to no series."""
    if class_id in (9, 10):
        _red_ring(canvas)
        left = pic.lorry_rear if class_id == 10 else pic.car_rear
        left(canvas, -0.33, 0.03, 0.5 if class_id == 10 else 0.56, pic.RED)
        pic.car_rear(canvas, 0.33, 0.08 if class_id == 10 else 0.03, 0.52, pic.BLACK)
    elif class_id in (41, 42):
        _end_base(canvas)
        left = pic.lorry_rear if class_id == 42 else pic.car_rear
        left(canvas, -0.4, 0.03, 0.56, GREY)
        pic.car_rear(canvas, 0.4, 0.08, 0.6, GREY)
        _end(canvas)
    elif class_id == 6:
        _end_base(canvas)
        write(canvas, "80", 0.86, 0, 0.01, GREY)
        _end(canvas)
    elif class_id == 32:
        _end_base(canvas)
        _end(canvas)
    elif class_id == 15:
        _red_ring(canvas)
    elif class_id == 16:
        _red_ring(canvas)
        pic.lorry_side(canvas, 0.0, 0.02, 1.16, pic.BLACK)
    elif class_id == 17:
        canvas.disc(0, 0, 1.1, pic.WHITE)
        canvas.disc(0, 0, 0.955, pic.RED)
        canvas.fill(pic.xy(-0.76, -0.17, 0.76, -0.17, 0.76, 0.17, -0.76, 0.17), pic.WHITE)
    elif class_id == 12:
        for radius, corner, colour in (
            (1.1, 0.08, pic.BLACK),
            (1.0, 0.07, pic.WHITE),
            (0.66, 0.03, pic.BLACK),
            (0.62, 0.03, YELLOW),
        ):
            canvas.fill(rounded(regular(4, radius, 0), corner), colour)
    elif class_id == 13:
        canvas.disc(0, 0, 2, pic.WHITE)
        canvas.fill(_triangle(1.07, 0.08, up=False), pic.RED)
        canvas.fill(_triangle(0.68, 0.04, up=False), pic.WHITE)
    else:
        canvas.disc(0, 0, 2, pic.WHITE)
        canvas.fill(rounded(regular(8, 0.955 / np.cos(np.pi / 8), 22.5), 0.05), pic.RED)
        write(canvas, "STOP", 0.66, 0, 0, pic.WHITE, 0.82)


def drawing(class_id: int) -> Canvas:
    """Draw a sign; its pictures span [-1, 1] x [-1, 1] of `outline`.

    Args:
        class_id: GTSRB class, 0 to 42.

    Returns:
        The drawing.

    Raises:
        ValueError: The class is not one of the 43.
    """
    silhouette = outline(class_id)
    canvas = Canvas()
    if class_id in _LIMITS:
        _red_ring(canvas)
        _limit(canvas, _LIMITS[class_id])
    elif class_id in _WARNINGS:
        _warning(canvas, _WARNINGS[class_id])
    elif class_id in _MANDATORY:
        canvas.disc(0, 0, 1.1, pic.WHITE)
        canvas.disc(0, 0, 0.955, BLUE)
        _MANDATORY[class_id](canvas)
    else:
        _special(canvas, class_id)
    canvas.outline(silhouette)
    return canvas
