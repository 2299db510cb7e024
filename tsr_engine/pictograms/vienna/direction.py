"""Section G: direction, position and indication signs, and the boards that stand at curves and works."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from tsr_engine.pictograms import arrows, facilities, people, roads, vehicles
from tsr_engine.pictograms.canvas import Canvas, Colour, arc, rounded
from tsr_engine.pictograms.figures import arrow
from tsr_engine.pictograms.palette import BLACK, BLUE, BROWN, GREEN, RED, WHITE, YELLOW
from tsr_engine.pictograms.plates import ON_BLUE, PLAIN, SQUARE, UPRIGHT, Symbol, board
from tsr_engine.pictograms.symbols import at, countdown, fitted, several


def _pointer(symbol: Symbol, *, ground: Colour, ink: Colour, left: bool = False) -> Canvas:
    """A board that ends in an arrowhead."""
    canvas = Canvas()
    body = canvas.placed(1, mirror=left)
    outer = np.array([(-0.98, -0.36), (0.6, -0.36), (0.98, 0), (0.6, 0.36), (-0.98, 0.36)])
    face = rounded(outer, 0.06)
    body.fill(face * 1.2, ink)
    body.fill(face * np.array([0.945, 0.87]), ground)
    symbol(canvas.placed(1, 0.12 if left else -0.12, colours={BLACK: ink, WHITE: ground}))
    canvas.outline(face * np.array([-1 if left else 1, 1]))
    return canvas


def _blue_pointer(*symbols: Symbol) -> Canvas:
    return _pointer(several(*symbols), ground=BLUE, ink=WHITE)


def _junction(canvas: Canvas) -> None:
    """A diagram of a junction with names at its arms."""
    arrow(canvas, "-10 94 -10 -50", 0.18, 0.44, BLACK)
    arrow(canvas, "-10 30 62 30", 0.14, 0.36, BLACK)
    fitted("BERN", 1.0, 0.28, -0.1, -0.76)(canvas)
    fitted("BASEL", 0.8, 0.24, 0.48, -0.06)(canvas)


def _round_junction(canvas: Canvas) -> None:
    """A diagram of a roundabout with three exits."""
    canvas.stroke(arc(0, 0, 0.34, 0.34, 0, 360, 60), 0.16, BLACK)
    canvas.stroke("0 94 0 34", 0.18, BLACK)
    for turn in (-90, 0, 90):
        arrow(canvas.placed(1, turn=turn), "0 -30 0 -92", 0.16, 0.42, BLACK)


def _stack(canvas: Canvas) -> None:
    """Three destinations above each other, each with its arrow."""
    for y, text, turn in ((-0.62, "BERN", 0), (0.0, "BASEL", -90), (0.62, "ROMA", 90)):
        arrow(canvas.placed(0.24, -0.68, y, turn=turn), "0 96 0 -98", 0.34, 0.9, BLACK)
        fitted(text, 1.1, 0.36, 0.22, y)(canvas)
        if y < 0.5:
            canvas.stroke(np.array([(-1.0, y + 0.31), (1.0, y + 0.31)]), 0.04, BLACK)


def _distances(canvas: Canvas) -> None:
    """Destinations with their distances."""
    for y, text, far in ((-0.3, "BERN", "8"), (0.3, "BASEL", "97")):
        fitted(text, 1.0, 0.36, -0.36, y)(canvas)
        fitted(far, 0.5, 0.36, 0.68, y)(canvas)


def _pass_road(canvas: Canvas) -> None:
    """The name of a pass above three fields: closed, chains, open as far as."""
    fitted("FURKA", 1.1, 0.28, 0, -0.66)(canvas.placed(1, colours={BLACK: WHITE}))
    canvas.fill("-56 -40 56 -40 56 -2 -56 -2", RED)
    fitted("CLOSED", 0.98, 0.24, 0, -0.21)(canvas.placed(1, colours={BLACK: WHITE}))
    canvas.fill("-56 6 56 6 56 44 -56 44", WHITE)
    canvas.disc(0, 0.25, 0.17, BLUE)
    vehicles.snow_chain(canvas.placed(0.11, 0, 0.25, colours=ON_BLUE))
    canvas.fill("-56 52 56 52 56 84 -56 84", WHITE)


def _exit_route(canvas: Canvas) -> None:
    """The runner with an arrow and a distance."""
    people.running_out(canvas.placed(0.66, -0.62, 0.0))
    arrow(canvas, "10 -24 92 -24", 0.14, 0.4, BLACK)
    fitted("150 m", 0.9, 0.32, 0.5, 0.34)(canvas)


def _shield(text: str, ground: Colour, ink: Colour, width: float) -> Canvas:
    return board((width, 0.5), fitted(text, width * 1.6, 0.56), 1.0, ground=ground, rim=ink, colours={BLACK: ink})


def _chevrons(canvas: Canvas) -> None:
    for x in (-0.62, 0.04, 0.7):
        arrows.chevron(canvas.placed(0.42, x, 0.0))


def _sight(canvas: Canvas) -> None:
    """A castle: a sight on the way."""
    canvas.fill(
        "-90 70 -90 -30 -74 -30 -74 -16 -58 -16 -58 -30 -42 -30 -42 -6 -20 -6 -20 -70 -8 -70 -8 -56 8 -56 8 -70 20 -70 "
        "20 -6 42 -6 42 -30 58 -30 58 -16 74 -16 74 -30 90 -30 90 70 16 70 16 36 Q 16 18 0 18 -16 18 -16 36 L -16 70",
        BLACK,
    )


_red_on_white = partial(board, ground=WHITE, colours=PLAIN)
DIRECTION: Final[dict[str, Callable[[], Canvas]]] = {
    "advance-direction-diagram": partial(board, SQUARE, _junction, 0.9),
    "advance-direction-at-roundabout": partial(board, SQUARE, _round_junction, 0.9),
    "advance-direction-list": partial(board, SQUARE, _stack, 0.9),
    "advance-no-through-road": partial(
        board, SQUARE, arrows.dead_end_to_right, 0.84, -0.04, 0.0, colours={BLACK: WHITE}
    ),
    "indirect-left-turn": partial(board, SQUARE, arrows.indirect_left, 0.86),
    "direction-to-the-right": partial(_pointer, fitted("BERN 15", 1.4, 0.4), ground=WHITE, ink=BLACK),
    "direction-to-the-left": partial(_pointer, fitted("BERN 15", 1.4, 0.4), ground=WHITE, ink=BLACK, left=True),
    "direction-to-motorway": partial(_blue_pointer, at(roads.motorway, 0.22, -0.52), fitted("ROMA", 0.8, 0.36, 0.2)),
    "direction-to-airport": partial(_blue_pointer, at(vehicles.aircraft, 0.24, -0.5), fitted("AIR", 0.8, 0.38, 0.2)),
    "direction-to-camping-site": partial(
        _blue_pointer, at(facilities.tent, 0.24, -0.5), at(vehicles.caravan, 0.32, 0.2, 0.06)
    ),
    "direction-to-youth-hostel": partial(_blue_pointer, at(facilities.house_and_tree, 0.28)),
    "direction-to-park-and-ride": partial(_blue_pointer, fitted("P+R", 0.62, 0.36, -0.42), at(vehicles.bus, 0.3, 0.42)),
    "tourist-direction": partial(_pointer, at(_sight, 0.32), ground=BROWN, ink=WHITE),
    "tourist-sight": partial(board, (0.98, 0.72), _sight, 0.72, ground=BROWN),
    "distances": partial(board, (0.98, 0.66), _distances, 0.88),
    "number-of-lanes": partial(board, SQUARE, arrows.lanes, 0.82),
    "lane-closed": partial(board, SQUARE, arrows.lane_closed, 0.82, colours={BLACK: WHITE}),
    "lane-ends": partial(board, SQUARE, arrows.lane_ends, 0.82),
    "no-through-road": partial(board, SQUARE, arrows.dead_end, 0.8, colours={BLACK: WHITE}),
    "road-open-or-closed": partial(board, UPRIGHT, _pass_road, 1.0, colours=PLAIN),
    "route-for-lorries": partial(
        board, SQUARE, several(at(vehicles.lorry, 0.8, 0, -0.36), at(arrows.arrow_right, 0.56, 0, 0.56)), 0.86
    ),
    "escape-lane": partial(board, SQUARE, roads.escape_lane, 0.82, colours={BLACK: WHITE}),
    "pedestrian-bridge-or-subway": partial(board, SQUARE, people.stairs_down, 0.8),
    "step-free-bridge-or-subway": partial(board, SQUARE, people.ramp, 0.8),
    "motorway-exit-countdown-3": partial(board, (0.42, 0.98), countdown(3, BLACK), 1.0),
    "motorway-exit-countdown-2": partial(board, (0.42, 0.98), countdown(2, BLACK), 1.0),
    "motorway-exit-countdown-1": partial(board, (0.42, 0.98), countdown(1, BLACK), 1.0),
    "motorway-exit": partial(
        board, (0.98, 0.6), several(fitted("EXIT", 1.1, 0.48, -0.3), at(arrows.arrow_up, 0.42, 0.66, 0, turn=45)), 0.88
    ),
    "emergency-exit": partial(board, SQUARE, people.running_out, 0.78, ground=GREEN),
    "emergency-exit-direction": partial(board, (0.98, 0.56), _exit_route, 0.88, ground=GREEN),
    "european-route-number": partial(_shield, "E 60", GREEN, WHITE, 0.98),
    "motorway-number": partial(_shield, "A 8", BLUE, WHITE, 0.86),
    "main-road-number": partial(_shield, "51", YELLOW, BLACK, 0.72),
    "diversion": partial(_pointer, fitted("DETOUR", 1.3, 0.38), ground=YELLOW, ink=BLACK),
    "chevron-to-the-right": partial(_red_on_white, (0.74, 0.86), arrows.chevron, 0.72),
    "chevron-to-the-left": partial(_red_on_white, (0.74, 0.86), arrows.chevron, 0.72, mirror=True),
    "chevrons-to-the-right": partial(_red_on_white, (0.98, 0.44), _chevrons, 1.0),
    "chevrons-to-the-left": partial(_red_on_white, (0.98, 0.44), _chevrons, 1.0, mirror=True),
    "hazard-marker-on-the-right": partial(_red_on_white, (0.3, 0.98), arrows.stripes_down_left, 1.0),
    "hazard-marker-on-the-left": partial(_red_on_white, (0.3, 0.98), arrows.stripes_down_left, 1.0, mirror=True),
    "barrier-board": partial(_red_on_white, (0.98, 0.24), arrows.barrier_beam, 1.0),
}
"""Makes the drawing of each key."""
