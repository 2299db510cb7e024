"""Arrows, junctions and lanes in black on white, each within the unit square."""

from __future__ import annotations

import numpy as np

from tsr_engine.pictograms.canvas import Canvas, arc
from tsr_engine.pictograms.figures import arrow
from tsr_engine.pictograms.palette import BLACK, RED, WHITE
from tsr_engine.pictograms.paths import path
from tsr_engine.pictograms.plates import triangle


def arrow_up(canvas: Canvas) -> None:
    """A broad arrow up."""
    arrow(canvas, "0 96 0 -98", 0.32, 0.86, BLACK)


def arrow_right(canvas: Canvas) -> None:
    """A broad arrow to the right."""
    arrow(canvas, "-96 0 98 0", 0.32, 0.86, BLACK)


def arrow_both(canvas: Canvas) -> None:
    """A broad arrow to both sides."""
    arrow(canvas, "0 0 98 0", 0.3, 0.78, BLACK)
    arrow(canvas, "0 0 -98 0", 0.3, 0.78, BLACK)


def fork_arrow(canvas: Canvas) -> None:
    """An arrow from below that parts to the left and to the right."""
    canvas.stroke("0 92 0 -8", 0.28, BLACK)
    for half in canvas.halves():
        arrow(half, "0 20 Q 0 -20 34 -20 L 98 -20", 0.28, 0.72, BLACK)


def pass_either_side(canvas: Canvas) -> None:
    """Two arrows obliquely down, one to each side."""
    for half in canvas.halves():
        arrow(half, "0 -60 0 -40 76 76", 0.26, 0.68, BLACK)
    canvas.stroke("0 -92 0 -34", 0.26, BLACK)


def turn_left(canvas: Canvas) -> None:
    """An arrow from below that bends to the left at a right angle."""
    arrow(canvas, "34 92 34 -8 Q 34 -30 12 -30 L -88 -30", 0.3, 0.78, BLACK)


def u_turn(canvas: Canvas) -> None:
    """An arrow up that turns back down on the left."""
    canvas.stroke(np.concatenate([path("42 92"), arc(0, -0.3, 0.42, 0.42, 0, -180, 24)]), 0.26, BLACK)
    arrow(canvas, "-42 -32 -42 88", 0.26, 0.7, BLACK)


def two_way(canvas: Canvas) -> None:
    """Two arrows side by side, the left one down, the right one up."""
    arrow(canvas, "-36 -92 -36 92", 0.24, 0.6, BLACK)
    arrow(canvas, "36 92 36 -92", 0.24, 0.6, BLACK)


def priority_to_oncoming(canvas: Canvas) -> None:
    """A small red arrow up on the right, a large black one down on the left."""
    arrow(canvas, "-36 -92 -36 96", 0.3, 0.76, BLACK)
    arrow(canvas, "44 84 44 -80", 0.2, 0.5, RED)


def priority_over_oncoming(canvas: Canvas) -> None:
    """A large white arrow up on the right, a small red one down on the left; for a blue ground."""
    arrow(canvas, "36 92 36 -96", 0.3, 0.76, BLACK)
    arrow(canvas, "-44 -80 -44 84", 0.2, 0.5, RED)


def circling(canvas: Canvas) -> None:
    """Three arrows that chase each other against the clock."""
    for k in range(3):
        third = canvas.placed(1, turn=120 * k)
        third.stroke(arc(0, 0, 0.7, 0.7, 84, 22, 24), 0.24, BLACK)
        third.fill(np.concatenate([arc(0, 0, r, r, at, at, 1) for r, at in ((0.4, 24), (1.0, 24), (0.72, -16))]), BLACK)


def crossroads(canvas: Canvas) -> None:
    """An oblique cross of equal roads."""
    canvas.stroke("-72 -72 72 72", 0.32, BLACK)
    canvas.stroke("-72 72 72 -72", 0.32, BLACK)


def t_junction(canvas: Canvas) -> None:
    """A road that ends at another one."""
    canvas.stroke("-90 -30 90 -30", 0.36, BLACK)
    canvas.stroke("0 96 0 -30", 0.36, BLACK)


def minor_from_right(canvas: Canvas) -> None:
    """A broad road with a narrow one from the right."""
    canvas.fill("-20 96 -20 -44 -38 -44 0 -100 38 -44 20 -44 20 96", BLACK)
    canvas.stroke("0 26 86 26", 0.2, BLACK)


def merging_from_right(canvas: Canvas) -> None:
    """A broad road that a narrow one joins obliquely from the right."""
    canvas.fill("-20 96 -20 -44 -38 -44 0 -100 38 -44 20 -44 20 96", BLACK)
    canvas.stroke("60 96 60 60 10 0", 0.2, BLACK)


def narrows_both(canvas: Canvas) -> None:
    """A road that narrows from both sides."""
    for half in canvas.halves():
        half.fill("72 96 72 44 30 0 30 -70 10 -70 10 10 48 54 48 96", BLACK)


def dead_end(canvas: Canvas) -> None:
    """A road that ends at a bar."""
    canvas.stroke("0 96 0 -50", 0.4, BLACK)
    canvas.fill("-70 -96 70 -96 70 -44 -70 -44", BLACK)
    canvas.fill("-64 -90 64 -90 64 -50 -64 -50", RED)


def dead_end_to_right(canvas: Canvas) -> None:
    """A road with a branch to the right that ends at a bar."""
    arrow(canvas, "-30 96 -30 -96", 0.34, 0.78, BLACK)
    canvas.stroke("-30 20 62 20", 0.28, BLACK)
    canvas.fill("54 -24 98 -24 98 64 54 64", BLACK)
    canvas.fill("60 -18 92 -18 92 58 60 58", RED)


def indirect_left(canvas: Canvas) -> None:
    """A way to the left that goes round the block on the right."""
    canvas.stroke("0 -40 0 -96", 0.1, BLACK)
    canvas.stroke("0 96 0 -26 Q 0 -52 26 -52 L 46 -52 Q 72 -52 72 -26 L 72 -8 Q 72 18 46 18 L 0 18", 0.17, BLACK)
    arrow(canvas, "10 18 -96 18", 0.17, 0.5, BLACK)


def lanes_ahead(canvas: Canvas) -> None:
    """Two lanes of which the right one turns off."""
    arrow(canvas, "-50 92 -50 -92", 0.22, 0.6, BLACK)
    arrow(canvas, "30 92 30 0 Q 30 -20 50 -20 L 96 -20", 0.22, 0.6, BLACK)
    for y in (60, 14, -32):
        canvas.fill(f"-14 {y} -6 {y} -6 {y + 26} -14 {y + 26}", BLACK)


def lanes(canvas: Canvas) -> None:
    """Two lanes in one direction, one in the other."""
    arrow(canvas, "-66 -92 -66 92", 0.2, 0.5, BLACK)
    for x in (0, 66):
        arrow(canvas, f"{x} 92 {x} -92", 0.2, 0.5, BLACK)


def lane_closed(canvas: Canvas) -> None:
    """Two lanes of which the right one ends at a bar."""
    arrow(canvas, "-40 92 -40 -92", 0.24, 0.64, BLACK)
    canvas.stroke("44 92 44 -16", 0.24, BLACK)
    canvas.fill("2 -52 86 -52 86 -8 2 -8", BLACK)
    canvas.fill("8 -46 80 -46 80 -14 8 -14", RED)


def lane_ends(canvas: Canvas) -> None:
    """Two lanes that become one: the right one joins the left one."""
    arrow(canvas, "-36 92 -36 -92", 0.24, 0.64, BLACK)
    canvas.stroke("46 92 46 44 -36 -16", 0.24, BLACK)


def give_way_ahead(canvas: Canvas) -> None:
    """The give-way triangle, small."""
    canvas.fill(triangle(1.0, 0.06, up=False), BLACK)
    canvas.fill(triangle(0.56, 0.03, up=False), WHITE)


def chevron(canvas: Canvas) -> None:
    """One angle that points to the right."""
    canvas.fill("-62 -100 0 -100 62 0 0 100 -62 100 0 0", RED)


def stripes_down_left(canvas: Canvas) -> None:
    """Bars that slope down to the left, over the whole face."""
    for k in range(-3, 4):
        y = 60 * k
        canvas.fill(f"-100 {y + 50} 100 {y - 50} 100 {y - 20} -100 {y + 80}", RED)


def barrier_beam(canvas: Canvas) -> None:
    """Red and white bars of a barrier."""
    for k in range(-1, 3):
        x = -100 + 66 * k
        canvas.fill(f"{x} 100 {x + 40} 100 {x + 74} -100 {x + 34} -100", RED)
