"""Section A: danger warning signs, and the signs at level crossings."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import arrows, figures, people, roads, vehicles
from tsr_engine.pictograms.canvas import Canvas, regular, rounded
from tsr_engine.pictograms.glyphs import write
from tsr_engine.pictograms.palette import BLACK, RED, WHITE
from tsr_engine.pictograms.plates import board, danger
from tsr_engine.pictograms.symbols import countdown, several


def _stop_octagon(canvas: Canvas) -> None:
    canvas.fill(rounded(regular(8, 1.0, 22.5), 0.06), BLACK)
    write(canvas, "STOP", 0.62, 0, 0, WHITE, 0.85)


def _slope(percent: str, *, ascent: bool) -> Canvas:
    """The ground rises to one corner of the inner triangle; the figure stands above its slope."""
    canvas = danger(several())
    ground = canvas.placed(1, mirror=ascent)
    ground.fill("-64 67 -42 24 64 67", BLACK)
    write(canvas.placed(1, 0.04 * (-1 if ascent else 1), 0.15), percent, 0.25, 0, 0, BLACK, 0.78)
    return canvas


def _st_andrew(*, double: bool) -> Canvas:
    canvas = Canvas()
    offsets = (-0.26, 0.3) if double else (0.0,)
    scale = 0.98
    if double:
        lower = canvas.placed(scale, 0, 0.3)
        lower.stroke("-88 47 0 0 88 47", 0.3, RED)
        lower.stroke("-50 27 0 0 50 27", 0.22, WHITE)
    roads.cross_of_st_andrew(canvas.placed(scale, 0, offsets[0]))
    for polygon in canvas.polygons():
        canvas.outline(polygon)
    return canvas


DANGER: Final[dict[str, Callable[[], Canvas]]] = {
    "double-curve-first-to-the-right": partial(danger, figures.double_bend, 1.0, 0.0, 0.0, mirror=True),
    "steep-descent": partial(_slope, "10%", ascent=False),
    "steep-ascent": partial(_slope, "10%", ascent=True),
    "road-narrows-on-both-sides": partial(danger, arrows.narrows_both, 0.46, 0.0, 0.18),
    "road-narrows-on-the-left": partial(danger, figures.narrows, 1.0, 0.0, 0.0, mirror=True),
    "swing-bridge": partial(danger, roads.swing_bridge, 0.44, 0.0, 0.26),
    "quay-or-river-bank": partial(danger, roads.quay, 0.47, 0.0, 0.22),
    "hump": partial(danger, roads.hump, 0.5, 0.0, 0.2),
    "dip": partial(danger, roads.dip, 0.46, 0.0, 0.22),
    "dangerous-shoulder": partial(danger, roads.soft_shoulder, 0.44, 0.0, 0.18),
    "loose-gravel": partial(danger, roads.loose_gravel, 0.44, 0.0, 0.24),
    "falling-rocks-from-the-right": partial(danger, roads.rocks_from_right, 0.6, 0.0, 0.07),
    "falling-rocks-from-the-left": partial(danger, roads.rocks_from_right, 0.6, 0.0, 0.07, mirror=True),
    "pedestrian-crossing-ahead": partial(danger, people.on_crossing, 0.5, 0.0, 0.16),
    "domestic-animals": partial(danger, people.cow, 0.46, 0.0, 0.24),
    "horse-riders": partial(danger, people.rider, 0.46, 0.0, 0.17),
    "amphibians": partial(danger, people.frog, 0.36, 0.0, 0.24),
    "crossroads": partial(danger, arrows.crossroads, 0.42, 0.0, 0.27),
    "t-junction": partial(danger, arrows.t_junction, 0.42, 0.0, 0.2),
    "minor-road-from-the-right": partial(danger, arrows.minor_from_right, 0.42, 0.0, 0.17),
    "minor-road-from-the-left": partial(danger, arrows.minor_from_right, 0.42, 0.0, 0.17, mirror=True),
    "merging-traffic-from-the-right": partial(danger, arrows.merging_from_right, 0.42, 0.0, 0.17),
    "merging-traffic-from-the-left": partial(danger, arrows.merging_from_right, 0.42, 0.0, 0.17, mirror=True),
    "give-way-ahead": partial(danger, arrows.give_way_ahead, 0.42, 0.0, 0.2),
    "stop-ahead": partial(danger, _stop_octagon, 0.38, 0.0, 0.25),
    "roundabout-ahead": partial(danger, arrows.circling, 0.34, 0.0, 0.27),
    "two-way-traffic": partial(danger, arrows.two_way, 0.4, 0.0, 0.22),
    "traffic-queues": partial(danger, roads.congestion, 0.48, 0.0, 0.16),
    "level-crossing-with-gates": partial(danger, roads.gate, 0.41, 0.0, 0.33),
    "level-crossing-without-gates": partial(danger, vehicles.locomotive, 0.46, 0.0, 0.28),
    "tram-crossing": partial(danger, vehicles.tram, 0.4, 0.0, 0.3),
    "tunnel-ahead": partial(danger, roads.tunnel, 0.38, 0.0, 0.28),
    "farm-vehicles": partial(danger, vehicles.tractor, 0.44, 0.0, 0.24),
    "low-flying-aircraft": partial(danger, vehicles.aircraft, 0.42, 0.02, 0.25),
    "cross-wind": partial(danger, roads.windsock, 0.43, 0.06, 0.27),
    "st-andrews-cross": partial(_st_andrew, double=False),
    "double-st-andrews-cross": partial(_st_andrew, double=True),
    "level-crossing-countdown-3": partial(board, (0.42, 0.98), countdown(3, RED), 1.0, ground=WHITE),
    "level-crossing-countdown-2": partial(board, (0.42, 0.98), countdown(2, RED), 1.0, ground=WHITE),
    "level-crossing-countdown-1": partial(board, (0.42, 0.98), countdown(1, RED), 1.0, ground=WHITE),
}
"""Makes the drawing of each key."""
