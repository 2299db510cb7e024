"""Section B: priority signs that the German 43 lack."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import arrows, gtsrb
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.glyphs import write
from tsr_engine.pictograms.palette import BLACK, BLUE, RED, WHITE
from tsr_engine.pictograms.plates import SQUARE, board, prohibition, triangle


def _end_of_priority() -> Canvas:
    canvas = gtsrb.drawing(12)
    for k in (-2, -1, 0, 1, 2):
        bar = canvas.placed(1, 0.09 * k, 0.09 * k)
        bar.stroke("-50 50 50 -50", 0.055, BLACK)
    return canvas


def _round_stop(canvas: Canvas) -> None:
    for radius, corner, colour in ((0.56, 0.05, RED), (0.3, 0.03, WHITE)):
        canvas.placed(1, 0, 0.36).fill(triangle(radius, corner, up=False), colour)
    write(canvas, "STOP", 0.27, 0, -0.43, BLACK, 1.0)


PRIORITY: Final[dict[str, Callable[[], Canvas]]] = {
    "round-stop": partial(prohibition, _round_stop, 1.0),
    "end-of-priority-road": _end_of_priority,
    "priority-for-oncoming-traffic": partial(prohibition, arrows.priority_to_oncoming, 0.56),
    "priority-over-oncoming-traffic": partial(
        board, SQUARE, arrows.priority_over_oncoming, 0.72, colours={BLACK: WHITE}, ground=BLUE
    ),
}
"""Makes the drawing of each key."""
