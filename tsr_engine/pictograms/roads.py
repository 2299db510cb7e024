"""Roads and what stands beside them, in black on white, each within the unit square."""

from __future__ import annotations

import numpy as np

from tsr_engine.pictograms.canvas import Canvas, arc
from tsr_engine.pictograms.figures import car_rear
from tsr_engine.pictograms.palette import BLACK, RED, WHITE
from tsr_engine.pictograms.paths import path
from tsr_engine.pictograms.vehicles import car_side, waves


def hump(canvas: Canvas) -> None:
    """One hump on a road."""
    canvas.fill("-98 56 -52 52 Q -30 44 -22 20 0 -24 22 20 30 44 52 52 L 98 56 98 84 -98 84", BLACK)


def dip(canvas: Canvas) -> None:
    """A dip in a road."""
    canvas.fill("-98 10 -54 10 Q -38 12 -24 34 0 64 24 34 38 12 54 10 L 98 10 98 84 -98 84", BLACK)


def swing_bridge(canvas: Canvas) -> None:
    """An opened bridge over water."""
    canvas.fill("-98 -2 -44 -2 -44 12 -52 12 -52 60 -98 60", BLACK)
    canvas.fill("98 -2 44 -2 44 12 52 12 52 60 98 60", BLACK)
    canvas.stroke("-46 -6 -8 -66", 0.15, BLACK)
    canvas.stroke("46 -6 8 -66", 0.15, BLACK)
    for y, reach in ((0.34, 0.47), (0.56, 0.47), (0.8, 1.0)):
        waves(canvas.placed(reach, 0, y), 0, 0.08 / reach)


def quay(canvas: Canvas) -> None:
    """A car that falls from a quay into the water."""
    canvas.fill("98 -4 34 -4 34 6 42 6 42 84 98 84", BLACK)
    car_side(canvas.placed(0.5, -0.1, 0.0, turn=-32))
    for y in (62, 82):
        canvas.stroke(
            f"-98 {y} Q -80 {y - 16} -64 {y} -46 {y + 16} -28 {y} -12 {y - 16} 6 {y} 20 {y + 14} 36 {y}",
            0.09,
            BLACK,
        )


def soft_shoulder(canvas: Canvas) -> None:
    """A car from behind that tips off the edge of a road."""
    canvas.fill("-98 60 12 60 32 84 98 84 98 96 -98 96", BLACK)
    car = canvas.placed(0.9, 0.1, 0.24, turn=13)
    car_rear(car, 0.0, -0.1, 1.2, BLACK)


def loose_gravel(canvas: Canvas) -> None:
    """A car whose wheels throw stones."""
    car = canvas.placed(0.72, -0.26, 0.1)
    car_rear(car, 0.0, 0.0, 1.7, BLACK)
    canvas.fill("-98 72 98 72 98 84 -98 84", BLACK)
    for x, y, r in (
        (0.5, 0.5, 0.08),
        (0.66, 0.3, 0.09),
        (0.58, 0.08, 0.07),
        (0.8, 0.52, 0.1),
        (0.84, 0.16, 0.06),
        (0.46, 0.24, 0.06),
    ):
        canvas.fill(arc(x, y, r, r, 0, 300, 6), BLACK)


def rocks_from_right(canvas: Canvas) -> None:
    """A cliff on the right with stones that fall from it."""
    canvas.fill("100 100 100 76 56 -14 42 -22 46 6 30 16 40 40 18 50 30 72 4 84 -10 100", BLACK)
    for x, y, r in ((0.1, 0.02, 0.14), (-0.14, 0.36, 0.16), (-0.36, 0.72, 0.19), (0.06, 0.56, 0.09)):
        canvas.fill(arc(x, y, r, r, 20, 320, 6), BLACK)


def congestion(canvas: Canvas) -> None:
    """Three cars behind each other, the nearest the largest."""
    for y, width in ((-0.74, 0.5), (-0.22, 0.68), (0.5, 0.96)):
        car_rear(canvas, 0.0, y, width, BLACK)


def gate(canvas: Canvas) -> None:
    """A fence: the gate of a level crossing."""
    for y in (-12, 34):
        canvas.fill(f"-92 {y} 92 {y} 92 {y + 16} -92 {y + 16}", BLACK)
    for x in (-80, -44, -8, 28, 64):
        canvas.fill(f"{x} 78 {x} -36 {x + 8} -50 {x + 16} -36 {x + 16} 78", BLACK)


def windsock(canvas: Canvas) -> None:
    """A wind sock, blown to the left."""
    canvas.stroke("46 92 46 -72", 0.09, BLACK, caps=True)
    canvas.fill("42 -66 42 -10 -98 40 -98 16", BLACK)
    for right, left in ((14, -10), (-34, -58)):
        (a, b), (c, d) = ((-62 + (42 - x) * 0.586, -14 + (42 - x) * 0.357) for x in (right, left))
        canvas.fill(f"{right} {a:.1f} {left} {c:.1f} {left} {d:.1f} {right} {b:.1f}", WHITE)


def tunnel(canvas: Canvas) -> None:
    """A road into the mouth of a tunnel."""
    canvas.fill(np.concatenate([path("-98 88"), arc(0, 0.06, 0.98, 0.98, 180, 360, 40), path("98 88")]), BLACK)
    canvas.fill(np.concatenate([path("-64 88"), arc(0, 0.1, 0.64, 0.64, 180, 360, 40), path("64 88")]), WHITE)
    canvas.fill("-50 88 -12 16 12 16 50 88", BLACK)
    for low, high in ((88, 66), (54, 40), (32, 22)):
        canvas.fill(f"-4 {low} -3 {high} 3 {high} 4 {low}", WHITE)


def motorway(canvas: Canvas) -> None:
    """Two carriageways below a bridge."""
    for half in canvas.halves():
        half.fill("8 96 78 96 26 -98 8 -98", BLACK)
    canvas.fill("-98 -40 98 -40 98 -8 -98 -8", WHITE)
    canvas.fill("-92 -34 92 -34 92 -16 -92 -16", BLACK)
    for half in canvas.halves():
        half.fill("80 -16 92 -16 92 12 80 12", BLACK)


def skyline(canvas: Canvas) -> None:
    """Houses and a church: a built-up area."""
    canvas.fill(
        "-98 60 -98 8 -84 -8 -70 8 -70 -14 -38 -14 -38 -30 -24 -92 -10 -30 -10 8 12 8 12 -22 28 -38 44 -22 44 4 66 4 "
        "66 -14 98 -14 98 60",
        BLACK,
    )
    for x, y in ((-60, 0), (-60, 22), (22, -10), (22, 14), (76, 2), (76, 24)):
        canvas.fill(f"{x} {y} {x + 12} {y} {x + 12} {y + 12} {x} {y + 12}", WHITE)


def escape_lane(canvas: Canvas) -> None:
    """A lane of deep gravel on the right of a road."""
    canvas.fill("-60 96 -60 -92 -20 -92 -20 -20 -20 96", BLACK)
    canvas.fill("-20 60 40 -30 40 -92 84 -92 84 -16 -20 96", BLACK)
    for y in (-82, -66, -50, -34):
        for x in (48, 64):
            canvas.fill(f"{x} {y} {x + 8} {y} {x + 8} {y + 8} {x} {y + 8}", RED)


def cross_of_st_andrew(canvas: Canvas) -> None:
    """The outline of one oblique cross with red ends."""
    for turn in (28, -28):
        arm = canvas.placed(1, turn=turn)
        arm.fill("-100 -15 100 -15 100 15 -100 15", RED)
    for turn in (28, -28):
        arm = canvas.placed(1, turn=turn)
        arm.fill("-96 -11 96 -11 96 11 -96 11", WHITE)
    for turn in (28, -28):
        arm = canvas.placed(1, turn=turn)
        for half in arm.halves():
            half.fill("52 -15 100 -15 100 15 52 15", RED)
