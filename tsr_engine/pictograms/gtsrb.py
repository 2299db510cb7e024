"""The 43 signs of GTSRB drawn as vectors in the German manner, at any resolution, with their silhouettes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tsr_engine.pictograms import figures as pic
from tsr_engine.pictograms.canvas import Canvas, regular, rounded
from tsr_engine.pictograms.glyphs import write
from tsr_engine.pictograms.palette import BLACK, GREY, RED, WHITE, YELLOW
from tsr_engine.pictograms.paths import Points
from tsr_engine.pictograms.plates import blue_disc, end_bars, end_ring, red_ring, round_face, triangle, warning_face
from tsr_engine.pictograms.symbols import figure

N_CLASSES = 43
"""Number of classes of GTSRB."""

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
        return triangle(2 / np.sqrt(3), 0.1, up=True)
    if class_id == 13:
        return triangle(2 / np.sqrt(3), 0.1, up=False)
    if class_id == 12:
        return rounded(regular(4, 1.03, 0), 0.08)
    if class_id == 14:
        return rounded(regular(8, 1 / np.cos(np.pi / 8), 22.5), 0.06)
    return round_face()


def nominal_width(class_id: int) -> float:
    """Width of the sign in its usual size, m; half of it is the unit of `outline`."""
    if class_id in _WARNINGS or class_id in (13, 14):
        return 0.9
    return 0.84 if class_id == 12 else 0.75 if class_id in (7, 8) else 0.6


def _special(canvas: Canvas, class_id: int) -> None:
    """Draw the signs that belong to no series."""
    if class_id in (9, 10):
        red_ring(canvas)
        left = pic.lorry_rear if class_id == 10 else pic.car_rear
        left(canvas, -0.33, 0.03, 0.5 if class_id == 10 else 0.56, RED)
        pic.car_rear(canvas, 0.33, 0.08 if class_id == 10 else 0.03, 0.52, BLACK)
    elif class_id in (41, 42):
        end_ring(canvas)
        left = pic.lorry_rear if class_id == 42 else pic.car_rear
        left(canvas, -0.4, 0.03, 0.56, GREY)
        pic.car_rear(canvas, 0.4, 0.08, 0.6, GREY)
        end_bars(canvas)
    elif class_id == 6:
        end_ring(canvas)
        write(canvas, "80", 0.86, 0, 0.01, GREY)
        end_bars(canvas)
    elif class_id == 32:
        end_ring(canvas)
        end_bars(canvas)
    elif class_id == 15:
        red_ring(canvas)
    elif class_id == 16:
        red_ring(canvas)
        pic.lorry_side(canvas, 0.0, 0.02, 1.16, BLACK)
    elif class_id == 17:
        canvas.disc(0, 0, 1.1, WHITE)
        canvas.disc(0, 0, 0.955, RED)
        canvas.fill("-76 -17 76 -17 76 17 -76 17", WHITE)
    elif class_id == 12:
        for radius, corner, colour in (
            (1.1, 0.08, BLACK),
            (1.0, 0.07, WHITE),
            (0.66, 0.03, BLACK),
            (0.62, 0.03, YELLOW),
        ):
            canvas.fill(rounded(regular(4, radius, 0), corner), colour)
    elif class_id == 13:
        canvas.disc(0, 0, 2, WHITE)
        canvas.fill(triangle(1.07, 0.08, up=False), RED)
        canvas.fill(triangle(0.68, 0.04, up=False), WHITE)
    else:
        canvas.disc(0, 0, 2, WHITE)
        canvas.fill(rounded(regular(8, 0.955 / np.cos(np.pi / 8), 22.5), 0.05), RED)
        write(canvas, "STOP", 0.66, 0, 0, WHITE, 0.82)


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
        red_ring(canvas)
        figure(_LIMITS[class_id])(canvas)
    elif class_id in _WARNINGS:
        warning_face(canvas)
        _WARNINGS[class_id](canvas)
    elif class_id in _MANDATORY:
        blue_disc(canvas)
        _MANDATORY[class_id](canvas)
    else:
        _special(canvas, class_id)
    canvas.outline(silhouette)
    return canvas
