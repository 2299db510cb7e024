"""Figures of the signs: vehicles, arrows, people, animals, as polygons and strokes in unit coordinates."""

from __future__ import annotations

import numpy as np

from tsr_engine.pictograms.canvas import Canvas, Colour, arc, as_points, turned
from tsr_engine.pictograms.palette import AMBER, BLACK, RED, SIGNAL_GREEN, WHITE
from tsr_engine.pictograms.paths import Points, path


def moved(points: Points, scale: float, dx: float, dy: float) -> Points:
    """Points scaled about the origin, then shifted."""
    return np.asarray(points * scale + np.array([dx, dy]))


def arrow(canvas: Canvas, line: Points | str, width: float, head: float, colour: Colour) -> None:
    """A broad arrow along a line.

    Args:
        canvas: Where to draw.
        line: (n, 2) centre line, or the text of a `path`; the tip lies at its last point.
        width: Width of the shaft.
        head: Width of the head; its length is 0.72 of that.
        colour: Colour (r, g, b).
    """
    line = as_points(line)
    along = line[-1] - line[-2]
    along = along / np.hypot(*along)
    side = np.array([-along[1], along[0]])
    neck = line[-1] - along * head * 0.72
    kept = line[:-1][((line[:-1] - neck) * along).sum(1) < 0]
    canvas.stroke(np.concatenate([kept, (neck + along * 0.02)[None]]), width, colour)
    canvas.fill(np.stack([line[-1], neck + side * head / 2, neck - side * head / 2]), colour)


def car_rear(canvas: Canvas, cx: float, cy: float, width: float, colour: Colour) -> None:
    """A passenger car from behind, as on the no-overtaking signs."""
    s = width / 2
    body = path("-100 45 -100 -10 -86 -22 -66 -75 -50 -85 50 -85 66 -75 86 -22 100 -10 100 45")
    canvas.fill(moved(body, s, cx, cy), colour)
    for x in (-0.74, 0.74):
        canvas.fill(moved(path("-19 40 19 40 19 80 -19 80"), s, cx + x * s, cy), colour)
        canvas.disc(cx + x * s, cy + 0.06 * s, 0.13 * s, WHITE)
    canvas.fill(moved(path("-62 -24 -46 -66 46 -66 62 -24"), s, cx, cy), WHITE)


def lorry_rear(canvas: Canvas, cx: float, cy: float, width: float, colour: Colour) -> None:
    """A lorry from behind."""
    s = width / 2
    canvas.fill(moved(path("-100 -135 100 -135 100 45 -100 45"), s, cx, cy), colour)
    canvas.fill(moved(path("-86 40 86 40 86 60 -86 60"), s, cx, cy), colour)
    for x in (-0.68, 0.68):
        canvas.fill(moved(path("-24 50 24 50 24 95 -24 95"), s, cx + x * s, cy), colour)


def lorry_side(canvas: Canvas, cx: float, cy: float, width: float, colour: Colour) -> None:
    """A lorry from the left, its cab on the left."""
    s = width / 2
    canvas.fill(moved(path("-42 -62 100 -62 100 28 -42 28"), s, cx, cy), colour)
    cab = path("-100 34 -100 -2 -86 -38 -50 -38 -50 28 100 28 100 38 -100 38")
    canvas.fill(moved(cab, s, cx, cy), colour)
    canvas.fill(moved(path("-90 -2 -80 -28 -60 -28 -60 -2"), s, cx, cy), WHITE)
    for x in (-0.72, 0.42, 0.74):
        canvas.disc(cx + x * s, cy + 0.42 * s, 0.205 * s, WHITE)
        canvas.disc(cx + x * s, cy + 0.42 * s, 0.165 * s, colour)


def crossing_priority(canvas: Canvas) -> None:
    """A broad arrow up with a thin crossing bar: right of way at the next crossing."""
    canvas.fill("-8 56 -8 -2 -15.5 -2 0 -26 15.5 -2 8 -2 8 56", BLACK)
    canvas.fill("-25 15 25 15 25 25 -25 25", BLACK)


def exclamation(canvas: Canvas) -> None:
    """An exclamation mark."""
    canvas.fill(np.concatenate([arc(0, -0.14, 0.085, 0.09, 180, 360), path("4 32 -4 32")]), BLACK)
    canvas.disc(0, 0.46, 0.075, BLACK)


def bend(canvas: Canvas, right: bool) -> None:
    """A curved arrow to one side."""
    s = 1 if right else -1
    line = np.concatenate([path("-12 56 -12 28"), arc(0.05, 0.22, 0.17, 0.17, 180, 270, 12), path("33 5")])
    arrow(canvas, line * np.array([s, 1]), 0.15, 0.32, BLACK)


def double_bend(canvas: Canvas) -> None:
    """A zigzag arrow that first goes left."""
    arrow(canvas, "14 57 14 13 -9 31 -9 -26", 0.14, 0.25, BLACK)


def bumps(canvas: Canvas) -> None:
    """Two humps on a line."""
    canvas.fill("-46 46 46 46 46 55 -46 55", BLACK)
    for x in (-0.21, 0.21):
        hump = np.concatenate([path("-24 48"), arc(0, 0.36, 0.12, 0.11, 200, 340, 12), path("24 48")])
        canvas.fill(moved(hump, 1, x, 0), BLACK)


def skid(canvas: Canvas) -> None:
    """A tilted car from behind over two winding tracks."""
    scale, y = 0.265, 0.13
    body = path("-100 30 -100 -14 -80 -24 -60 -72 60 -72 80 -24 100 -14 100 30")
    canvas.fill(moved(turned(body, 12), scale, 0.02, y), BLACK)
    canvas.fill(moved(turned(path("-56 -24 -46 -58 46 -58 56 -24"), 12), scale, 0.02, y), WHITE)
    for x in (-0.72, 0.72):
        wheel = path("-17 25 17 25 17 60 -17 60") + np.array([x, 0.0])
        canvas.fill(moved(turned(wheel, 12), scale, 0.02, y), BLACK)
    t = np.linspace(0, 1, 30)
    for x, low in ((-0.2, 0.30), (0.14, 0.38)):
        wave = np.stack([x + 0.12 * np.sin(2 * np.pi * t * 0.95) + 0.16 * t, low + (0.57 - low) * t], axis=1)
        canvas.stroke(wave, 0.04, BLACK)


def narrows(canvas: Canvas) -> None:
    """A road that narrows from the right."""
    canvas.fill("-20 57 -20 -14 -9 -14 -9 57", BLACK)
    canvas.fill("30 57 30 34 12 14 12 -14 1 -14 1 20 18 38 18 57", BLACK)


def roadworks(canvas: Canvas) -> None:
    """A digging man and a heap."""
    canvas.disc(-0.07, -0.13, 0.075, BLACK)
    canvas.stroke("-12 -2 -20 25", 0.15, BLACK, caps=True)
    canvas.stroke("-20 25 -12 40 -17 57", 0.085, BLACK, caps=False)
    canvas.stroke("-22 25 -30 42 -38 57", 0.085, BLACK)
    canvas.stroke("-10 0 5 16 -2 22", 0.06, BLACK, caps=True)
    canvas.stroke("-22 16 22 40", 0.035, BLACK)
    heap = np.concatenate([path("0 58"), arc(0.24, 0.5, 0.14, 0.2, 195, 345, 12), path("47 58")])
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
        stroke(path("-4 -22 5 10"), 0.2)
        stroke(path("3 12 -16 24 -18 50"), 0.1)
        stroke(path("6 12 20 30 40 36"), 0.1)
        stroke(path("-6 -20 -26 -8 -36 -18"), 0.075)
        stroke(path("2 -20 20 -6 30 -14"), 0.075)
    else:
        stroke(path("1 -20 3 10"), 0.2)
        stroke(path("0 10 -11 32 -20 57"), 0.1)
        stroke(path("5 10 14 32 18 57"), 0.1)
        stroke(path("-5 -20 -19 -4 -20 10"), 0.07)
        stroke(path("7 -20 18 -4 24 7"), 0.07)


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
        path("-26 36 -12 10 17 10 -2 36 -26 36"),
        path("-2 36 -15 2"),
        path("26 36 13 -4 23 -6"),
        path("-23 1 -8 1"),
    ):
        canvas.stroke(moved(points, scale, 0.0, dy), w, BLACK, caps=True)


def snowflake(canvas: Canvas) -> None:
    """A six-armed ice crystal."""
    for k in range(6):
        for points, width in ((path("0 0 0 -34"), 0.052), (path("-10 -30 0 -17 10 -30"), 0.046)):
            canvas.stroke(moved(turned(points, 60 * k), 0.98, 0, 0.2), width, BLACK)


def deer(canvas: Canvas) -> None:
    """A leaping stag, to the left."""
    body = path(
        "-30 -6 -20 -14 -13 -14 -5 8 10 15 27 22 31 30 28 38 38 52 36 55 24 43 14 37 0 34 -10 32 -15 24 -16 6 -27 0"
    )
    canvas.fill(body, BLACK)
    canvas.stroke("-11 28 -30 29 -37 40", 0.055, BLACK, caps=True)
    canvas.stroke("-7 29 -22 37 -25 49", 0.055, BLACK, caps=True)
    canvas.stroke("20 38 27 48 42 58", 0.05, BLACK, caps=True)
    canvas.stroke("29 24 36 20", 0.05, BLACK, caps=True)
    for points in (
        path("-15 -12 -6 -20 -8 -32"),
        path("-8 -19 2 -25"),
        path("-19 -13 -18 -26"),
    ):
        canvas.stroke(points, 0.032, BLACK, caps=True)


def circling(canvas: Canvas) -> None:
    """Three arrows that chase each other against the clock: roundabout (traffic keeps right)."""
    for k in range(3):
        arrow(canvas, arc(0, 0, 0.53, 0.53, 95 + 120 * k, 8 + 120 * k, 24), 0.17, 0.38, WHITE)


def turn_ahead(canvas: Canvas, right: bool) -> None:
    """A broad arrow that comes from below and bends to one side."""
    s = 1 if right else -1
    line = np.concatenate([path("-30 52 -30 20"), arc(0.0, 0.14, 0.3, 0.3, 180, 270, 14), path("14 -16 66 -16")])
    arrow(canvas, line * np.array([s, 1]), 0.25, 0.58, WHITE)


def straight(canvas: Canvas) -> None:
    """A broad arrow up."""
    arrow(canvas, "0 64 0 -70", 0.24, 0.66, WHITE)


def straight_or(canvas: Canvas, right: bool) -> None:
    """An arrow up with a branch to one side."""
    s = np.array([1 if right else -1, 1])
    arrow(canvas, path("-16 66 -16 -74") * s, 0.2, 0.46, WHITE)
    branch = np.concatenate([path("-16 52"), arc(0.12, 0.44, 0.28, 0.28, 180, 270, 12), path("62 16")])
    arrow(canvas, branch * s, 0.2, 0.46, WHITE)


def keep(canvas: Canvas, right: bool) -> None:
    """A broad arrow obliquely down to one side."""
    s = 1 if right else -1
    arrow(canvas, path("-47 -47 50 50") * np.array([s, 1]), 0.26, 0.72, WHITE)
