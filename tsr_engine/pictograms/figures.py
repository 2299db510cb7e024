"""Figures of the signs: vehicles, arrows, people, animals, as polygons and strokes in unit coordinates."""

from __future__ import annotations

import numpy as np

from tsr_engine.pictograms.canvas import Canvas, Colour, Points, arc, turned
from tsr_engine.pictograms.palette import AMBER, BLACK, RED, SIGNAL_GREEN, WHITE


def xy(*flat: float) -> Points:
    """Points from a flat list x, y, x, y, ..."""
    return np.array(flat, np.float64).reshape(-1, 2)


def moved(points: Points, scale: float, dx: float, dy: float) -> Points:
    """Points scaled about the origin, then shifted."""
    return np.asarray(points * scale + np.array([dx, dy]))


def arrow(canvas: Canvas, path: Points, width: float, head: float, colour: Colour) -> None:
    """A broad arrow along a path.

    Args:
        canvas: Where to draw.
        path: (n, 2) centre line; the tip lies at its last point.
        width: Width of the shaft.
        head: Width of the head; its length is 0.75 of that.
        colour: Colour (r, g, b).
    """
    along = path[-1] - path[-2]
    along = along / np.hypot(*along)
    side = np.array([-along[1], along[0]])
    neck = path[-1] - along * head * 0.72
    kept = path[:-1][((path[:-1] - neck) * along).sum(1) < 0]
    canvas.stroke(np.concatenate([kept, (neck + along * 0.02)[None]]), width, colour)
    canvas.fill(np.stack([path[-1], neck + side * head / 2, neck - side * head / 2]), colour)


def car_rear(canvas: Canvas, cx: float, cy: float, width: float, colour: Colour) -> None:
    """A passenger car from behind, as on the no-overtaking signs."""
    s = width / 2
    body = xy(
        -1,
        0.45,
        -1,
        -0.1,
        -0.86,
        -0.22,
        -0.66,
        -0.75,
        -0.5,
        -0.85,
        0.5,
        -0.85,
        0.66,
        -0.75,
        0.86,
        -0.22,
        1,
        -0.1,
        1,
        0.45,
    )
    canvas.fill(moved(body, s, cx, cy), colour)
    for x in (-0.74, 0.74):
        canvas.fill(moved(xy(-0.19, 0.4, 0.19, 0.4, 0.19, 0.8, -0.19, 0.8), s, cx + x * s, cy), colour)
        canvas.disc(cx + x * s, cy + 0.06 * s, 0.13 * s, WHITE)
    canvas.fill(moved(xy(-0.62, -0.24, -0.46, -0.66, 0.46, -0.66, 0.62, -0.24), s, cx, cy), WHITE)


def lorry_rear(canvas: Canvas, cx: float, cy: float, width: float, colour: Colour) -> None:
    """A lorry from behind."""
    s = width / 2
    canvas.fill(moved(xy(-1, -1.35, 1, -1.35, 1, 0.45, -1, 0.45), s, cx, cy), colour)
    canvas.fill(moved(xy(-0.86, 0.4, 0.86, 0.4, 0.86, 0.6, -0.86, 0.6), s, cx, cy), colour)
    for x in (-0.68, 0.68):
        canvas.fill(moved(xy(-0.24, 0.5, 0.24, 0.5, 0.24, 0.95, -0.24, 0.95), s, cx + x * s, cy), colour)


def lorry_side(canvas: Canvas, cx: float, cy: float, width: float, colour: Colour) -> None:
    """A lorry from the left, its cab on the left."""
    s = width / 2
    canvas.fill(moved(xy(-0.42, -0.62, 1, -0.62, 1, 0.28, -0.42, 0.28), s, cx, cy), colour)
    cab = xy(-1, 0.34, -1, -0.02, -0.86, -0.38, -0.5, -0.38, -0.5, 0.28, 1, 0.28, 1, 0.38, -1, 0.38)
    canvas.fill(moved(cab, s, cx, cy), colour)
    canvas.fill(moved(xy(-0.9, -0.02, -0.8, -0.28, -0.6, -0.28, -0.6, -0.02), s, cx, cy), WHITE)
    for x in (-0.72, 0.42, 0.74):
        canvas.disc(cx + x * s, cy + 0.42 * s, 0.205 * s, WHITE)
        canvas.disc(cx + x * s, cy + 0.42 * s, 0.165 * s, colour)


def crossing_priority(canvas: Canvas) -> None:
    """A broad arrow up with a thin crossing bar: right of way at the next crossing."""
    canvas.fill(xy(-0.08, 0.56, -0.08, -0.02, -0.155, -0.02, 0, -0.26, 0.155, -0.02, 0.08, -0.02, 0.08, 0.56), BLACK)
    canvas.fill(xy(-0.25, 0.15, 0.25, 0.15, 0.25, 0.25, -0.25, 0.25), BLACK)


def exclamation(canvas: Canvas) -> None:
    """An exclamation mark."""
    canvas.fill(np.concatenate([arc(0, -0.14, 0.085, 0.09, 180, 360), xy(0.04, 0.32, -0.04, 0.32)]), BLACK)
    canvas.disc(0, 0.46, 0.075, BLACK)


def bend(canvas: Canvas, right: bool) -> None:
    """A curved arrow to one side."""
    s = 1 if right else -1
    path = np.concatenate([xy(-0.12, 0.56, -0.12, 0.28), arc(0.05, 0.22, 0.17, 0.17, 180, 270, 12), xy(0.33, 0.05)])
    arrow(canvas, path * np.array([s, 1]), 0.15, 0.32, BLACK)


def double_bend(canvas: Canvas) -> None:
    """A zigzag arrow that first goes left."""
    arrow(canvas, xy(0.14, 0.57, 0.14, 0.13, -0.09, 0.31, -0.09, -0.26), 0.14, 0.25, BLACK)


def bumps(canvas: Canvas) -> None:
    """Two humps on a line."""
    canvas.fill(xy(-0.46, 0.46, 0.46, 0.46, 0.46, 0.55, -0.46, 0.55), BLACK)
    for x in (-0.21, 0.21):
        hump = np.concatenate([xy(-0.24, 0.48), arc(0, 0.36, 0.12, 0.11, 200, 340, 12), xy(0.24, 0.48)])
        canvas.fill(moved(hump, 1, x, 0), BLACK)


def skid(canvas: Canvas) -> None:
    """A tilted car from behind over two winding tracks."""
    scale, y = 0.265, 0.13
    body = xy(-1, 0.3, -1, -0.14, -0.8, -0.24, -0.6, -0.72, 0.6, -0.72, 0.8, -0.24, 1, -0.14, 1, 0.3)
    canvas.fill(moved(turned(body, 12), scale, 0.02, y), BLACK)
    canvas.fill(moved(turned(xy(-0.56, -0.24, -0.46, -0.58, 0.46, -0.58, 0.56, -0.24), 12), scale, 0.02, y), WHITE)
    for x in (-0.72, 0.72):
        wheel = xy(x - 0.17, 0.25, x + 0.17, 0.25, x + 0.17, 0.6, x - 0.17, 0.6)
        canvas.fill(moved(turned(wheel, 12), scale, 0.02, y), BLACK)
    t = np.linspace(0, 1, 30)
    for x, low in ((-0.2, 0.30), (0.14, 0.38)):
        wave = np.stack([x + 0.12 * np.sin(2 * np.pi * t * 0.95) + 0.16 * t, low + (0.57 - low) * t], axis=1)
        canvas.stroke(wave, 0.04, BLACK)


def narrows(canvas: Canvas) -> None:
    """A road that narrows from the right."""
    canvas.fill(xy(-0.2, 0.57, -0.2, -0.14, -0.09, -0.14, -0.09, 0.57), BLACK)
    canvas.fill(
        xy(0.3, 0.57, 0.3, 0.34, 0.12, 0.14, 0.12, -0.14, 0.01, -0.14, 0.01, 0.2, 0.18, 0.38, 0.18, 0.57), BLACK
    )


def roadworks(canvas: Canvas) -> None:
    """A digging man and a heap."""
    canvas.disc(-0.07, -0.13, 0.075, BLACK)
    canvas.stroke(xy(-0.12, -0.02, -0.2, 0.25), 0.15, BLACK, caps=True)
    canvas.stroke(xy(-0.2, 0.25, -0.12, 0.4, -0.17, 0.57), 0.085, BLACK, caps=False)
    canvas.stroke(xy(-0.22, 0.25, -0.3, 0.42, -0.38, 0.57), 0.085, BLACK)
    canvas.stroke(xy(-0.1, 0.0, 0.05, 0.16, -0.02, 0.22), 0.06, BLACK, caps=True)
    canvas.stroke(xy(-0.22, 0.16, 0.22, 0.4), 0.035, BLACK)
    heap = np.concatenate([xy(0.0, 0.58), arc(0.24, 0.5, 0.14, 0.2, 195, 345, 12), xy(0.47, 0.58)])
    canvas.fill(heap, BLACK)


def lights(canvas: Canvas) -> None:
    """Three lamps one above the other."""
    for y, colour in ((-0.10, RED), (0.15, AMBER), (0.40, SIGNAL_GREEN)):
        canvas.disc(0, y, 0.098, colour)


def walker(canvas: Canvas, scale: float, dx: float, dy: float, *, running: bool = False) -> None:
    """A man from the side, walking to the left or running; about 1.1 high at a scale of 1."""

    def stroke(points: Points, width: float) -> None:
        canvas.stroke(moved(points, scale, dx, dy), width * scale, BLACK, caps=True)

    canvas.disc(dx + (-0.06 if running else 0.0) * scale, dy - 0.40 * scale, 0.095 * scale, BLACK)
    if running:
        stroke(xy(-0.04, -0.22, 0.05, 0.1), 0.2)
        stroke(xy(0.03, 0.12, -0.16, 0.24, -0.18, 0.5), 0.1)
        stroke(xy(0.06, 0.12, 0.2, 0.3, 0.4, 0.36), 0.1)
        stroke(xy(-0.06, -0.2, -0.26, -0.08, -0.36, -0.18), 0.075)
        stroke(xy(0.02, -0.2, 0.2, -0.06, 0.3, -0.14), 0.075)
    else:
        stroke(xy(0.01, -0.2, 0.03, 0.1), 0.2)
        stroke(xy(0.0, 0.1, -0.11, 0.32, -0.2, 0.57), 0.1)
        stroke(xy(0.05, 0.1, 0.14, 0.32, 0.18, 0.57), 0.1)
        stroke(xy(-0.05, -0.2, -0.19, -0.04, -0.2, 0.1), 0.07)
        stroke(xy(0.07, -0.2, 0.18, -0.04, 0.24, 0.07), 0.07)


def pedestrian(canvas: Canvas) -> None:
    """A walking man."""
    walker(canvas, 0.86, 0.0, 0.1)


def children(canvas: Canvas) -> None:
    """Two running children hand in hand, the taller on the right."""
    walker(canvas, 0.72, 0.14, 0.16, running=True)
    walker(canvas, 0.56, -0.24, 0.28, running=True)


def bicycle(canvas: Canvas) -> None:
    """A bicycle from the side."""
    scale, dy, w = 0.84, 0.09, 0.038
    for x in (-0.26, 0.26):
        canvas.disc(x * scale, 0.36 * scale + dy, 0.185 * scale, BLACK)
        canvas.disc(x * scale, 0.36 * scale + dy, 0.148 * scale, WHITE)
    for points in (
        xy(-0.26, 0.36, -0.12, 0.1, 0.17, 0.1, -0.02, 0.36, -0.26, 0.36),
        xy(-0.02, 0.36, -0.15, 0.02),
        xy(0.26, 0.36, 0.13, -0.04, 0.23, -0.06),
        xy(-0.23, 0.01, -0.08, 0.01),
    ):
        canvas.stroke(moved(points, scale, 0.0, dy), w, BLACK, caps=True)


def snowflake(canvas: Canvas) -> None:
    """A six-armed ice crystal."""
    for k in range(6):
        for points, width in ((xy(0, 0, 0, -0.34), 0.052), (xy(-0.1, -0.3, 0, -0.17, 0.1, -0.3), 0.046)):
            canvas.stroke(moved(turned(points, 60 * k), 0.98, 0, 0.2), width, BLACK)


def deer(canvas: Canvas) -> None:
    """A leaping stag, to the left."""
    body = xy(
        -0.3,
        -0.06,
        -0.2,
        -0.14,
        -0.13,
        -0.14,
        -0.05,
        0.08,
        0.1,
        0.15,
        0.27,
        0.22,
        0.31,
        0.3,
        0.28,
        0.38,
        0.38,
        0.52,
        0.36,
        0.55,
        0.24,
        0.43,
        0.14,
        0.37,
        0.0,
        0.34,
        -0.1,
        0.32,
        -0.15,
        0.24,
        -0.16,
        0.06,
        -0.27,
        0.0,
    )
    canvas.fill(body, BLACK)
    canvas.stroke(xy(-0.11, 0.28, -0.3, 0.29, -0.37, 0.4), 0.055, BLACK, caps=True)
    canvas.stroke(xy(-0.07, 0.29, -0.22, 0.37, -0.25, 0.49), 0.055, BLACK, caps=True)
    canvas.stroke(xy(0.2, 0.38, 0.27, 0.48, 0.42, 0.58), 0.05, BLACK, caps=True)
    canvas.stroke(xy(0.29, 0.24, 0.36, 0.2), 0.05, BLACK, caps=True)
    for points in (
        xy(-0.15, -0.12, -0.06, -0.2, -0.08, -0.32),
        xy(-0.08, -0.19, 0.02, -0.25),
        xy(-0.19, -0.13, -0.18, -0.26),
    ):
        canvas.stroke(points, 0.032, BLACK, caps=True)


def circling(canvas: Canvas) -> None:
    """Three arrows that chase each other against the clock: roundabout (traffic keeps right)."""
    for k in range(3):
        path = arc(0, 0, 0.53, 0.53, 95 + 120 * k, 8 + 120 * k, 24)
        arrow(canvas, path, 0.17, 0.38, WHITE)


def turn_ahead(canvas: Canvas, right: bool) -> None:
    """A broad arrow that comes from below and bends to one side."""
    s = 1 if right else -1
    path = np.concatenate(
        [xy(-0.3, 0.52, -0.3, 0.2), arc(0.0, 0.14, 0.3, 0.3, 180, 270, 14), xy(0.14, -0.16, 0.66, -0.16)]
    )
    arrow(canvas, path * np.array([s, 1]), 0.25, 0.58, WHITE)


def straight(canvas: Canvas) -> None:
    """A broad arrow up."""
    arrow(canvas, xy(0, 0.64, 0, -0.7), 0.24, 0.66, WHITE)


def straight_or(canvas: Canvas, right: bool) -> None:
    """An arrow up with a branch to one side."""
    s = np.array([1 if right else -1, 1])
    arrow(canvas, xy(-0.16, 0.66, -0.16, -0.74) * s, 0.2, 0.46, WHITE)
    branch = np.concatenate([xy(-0.16, 0.52), arc(0.12, 0.44, 0.28, 0.28, 180, 270, 12), xy(0.62, 0.16)])
    arrow(canvas, branch * s, 0.2, 0.46, WHITE)


def keep(canvas: Canvas, right: bool) -> None:
    """A broad arrow obliquely down to one side."""
    s = 1 if right else -1
    arrow(canvas, xy(-0.47, -0.47, 0.5, 0.5) * np.array([s, 1]), 0.26, 0.72, WHITE)
