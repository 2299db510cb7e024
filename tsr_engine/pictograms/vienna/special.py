"""Section E: special regulation signs, other than zones."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import arrows, facilities, people, roads, vehicles
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.figures import arrow
from tsr_engine.pictograms.glyphs import write
from tsr_engine.pictograms.palette import BLACK, BLUE, GREEN, RED, WHITE, YELLOW
from tsr_engine.pictograms.plates import FLAT, ON_BLUE, PLAIN, SQUARE, UPRIGHT, Symbol, board, round_face, triangle
from tsr_engine.pictograms.symbols import at, disc, fitted, plate, ring, several, words


def _lanes(*signs: Symbol | None) -> Canvas:
    """Arrows up side by side, each with a small round sign."""

    def symbol(canvas: Canvas) -> None:
        step = 1.8 / len(signs)
        for k, sign in enumerate(signs):
            x = step * (k - (len(signs) - 1) / 2)
            arrow(canvas.placed(1, x), "0 70 0 -72", 0.2, 0.5, WHITE)
            if sign is not None:
                canvas.disc(x, 0.2, 0.27, WHITE)
                sign(canvas.placed(0.25, x, 0.2))

    return board((0.98, 0.84), symbol, 1.0, colours=PLAIN)


def _small_figure(text: str) -> Symbol:
    return words(text, 0.86, squeeze=0.85)


def _bus_lane(canvas: Canvas) -> None:
    """Three lanes, the right one with a bus."""
    for x in (-0.72, -0.14):
        arrow(canvas.placed(1, x), "0 74 0 -84", 0.2, 0.46, BLACK)
    for x in (-43, 17):
        for y in (-80, -40, 0, 40):
            canvas.fill(f"{x - 3} {y} {x + 3} {y} {x + 3} {y + 24} {x - 3} {y + 24}", BLACK)
    arrow(canvas.placed(1, 0.6), "0 20 0 -84", 0.2, 0.46, BLACK)
    canvas.placed(0.36, 0.6, 0.3).fill("-98 66 -98 -66 98 -66 98 66", BLACK)
    vehicles.bus(canvas.placed(0.31, 0.6, 0.32, colours={BLACK: WHITE, WHITE: BLACK}))


def _triangle(symbol: Symbol) -> Symbol:
    """A white triangle with a black symbol, for a blue ground."""

    def small(canvas: Canvas) -> None:
        canvas.fill(triangle(0.98, 0.05, up=True), WHITE)
        symbol(canvas)

    return small


def _crossing_with_bicycle(canvas: Canvas) -> None:
    people.walker(canvas.placed(0.36, 0.0, 0.02))
    vehicles.bicycle(canvas.placed(0.4, 0.0, 0.5))


def _stop_post(symbol: Symbol) -> Canvas:
    """A white square with a black vehicle on a blue upright board: a stop."""

    def both(canvas: Canvas) -> None:
        canvas.fill("-54 -74 54 -74 54 34 -54 34", WHITE)
        symbol(canvas.placed(0.48, 0, -0.2))

    return board(UPRIGHT, both, 1.0, colours=PLAIN)


def _halt(canvas: Canvas) -> None:
    write(canvas, "H", 1.1, 0, 0, GREEN)


def _round_stop() -> Canvas:
    canvas = Canvas()
    canvas.disc(0, 0, 1.1, GREEN)
    canvas.disc(0, 0, 0.8, YELLOW)
    _halt(canvas.placed(0.9))
    canvas.outline(round_face())
    return canvas


def _bed_and_cross(canvas: Canvas) -> None:
    facilities.bed(canvas.placed(0.7, 0, 0.38))
    plate(facilities.red_cross, 0.98, 0.98)(canvas.placed(0.3, 0, -0.42))


def _lay_by(canvas: Canvas) -> None:
    """A car in a bay beside the road."""
    canvas.stroke("-48 94 -48 -94", 0.1, BLACK)
    canvas.fill("-30 94 -30 -94 10 -94 10 -64 62 -40 62 40 10 64 10 94", BLACK)
    vehicles.car_rear(canvas.placed(0.24, 0.32, 0.0, colours={BLACK: WHITE, WHITE: BLACK}))


def _parking(extra: Symbol) -> Symbol:
    return several(words("P", 0.86, -0.02, -0.44), extra)


def _pavement_parking(canvas: Canvas) -> None:
    """A car with two wheels on the footway."""
    vehicles.car_rear(canvas.placed(0.4, 0.0, 0.4, turn=-7))
    canvas.fill("-70 86 6 86 6 76 70 76 70 90 -70 90", BLACK)


def _general_limits(canvas: Canvas) -> None:
    """The general limits of a country: in built-up areas, outside, on motorways."""
    write(canvas, "A", 0.2, 0, -0.8, WHITE)
    for k, (symbol, text) in enumerate(((roads.skyline, "50"), (roads.skyline, "100"), (roads.motorway, "130"))):
        y = -0.4 + 0.5 * k
        canvas.placed(1, 0, y).fill("-60 -22 60 -22 60 22 -60 22", WHITE)
        if k == 2:
            canvas.placed(1, -0.3, y).fill("-24 -19 24 -19 24 19 -24 19", BLUE)
            symbol(canvas.placed(0.17, -0.3, y, colours=ON_BLUE))
        else:
            symbol(canvas.placed(0.24, -0.3, y + 0.03))
        if k == 1:
            canvas.placed(1, -0.3, y).stroke("-22 18 22 -18", 0.05, RED)
        at(ring(words(text, 0.7, squeeze=0.7 if len(text) == 3 else 0.95)), 0.2, 0.32, y)(canvas)


_built_up_area = partial(board, (0.98, 0.62), roads.skyline, 0.8, 0.0, 0.08, ground=WHITE, rim=BLACK)
_place_name = partial(board, (0.98, 0.62), fitted("ULM", 1.5, 0.6), 1.0, ground=YELLOW, rim=BLACK)
SPECIAL: Final[dict[str, Callable[[], Canvas]]] = {
    "minimum-speeds-by-lane": partial(_lanes, disc(_small_figure("60")), disc(_small_figure("30"))),
    "minimum-speed-on-one-lane": partial(_lanes, disc(_small_figure("60")), None),
    "speed-limits-by-lane": partial(_lanes, *(ring(words(text, 0.74, squeeze=0.85)) for text in ("80", "60", "40"))),
    "bus-lane": partial(board, SQUARE, _bus_lane, 0.9),
    "one-way": partial(board, SQUARE, arrows.arrow_up, 0.78),
    "one-way-to-the-right": partial(board, (0.98, 0.4), arrows.arrow_right, 0.82),
    "one-way-to-the-left": partial(board, (0.98, 0.4), arrows.arrow_right, 0.82, mirror=True),
    "lane-preselection": partial(board, SQUARE, arrows.lanes_ahead, 0.78),
    "motorway": partial(board, SQUARE, roads.motorway, 0.74),
    "end-of-motorway": partial(board, SQUARE, roads.motorway, 0.74, ended=True),
    "road-for-motor-vehicles": partial(board, SQUARE, vehicles.car_front, 0.68),
    "end-of-road-for-motor-vehicles": partial(board, SQUARE, vehicles.car_front, 0.68, ended=True),
    "built-up-area": _built_up_area,
    "end-of-built-up-area": partial(_built_up_area, ended=True),
    "place-name": _place_name,
    "end-of-place-name": partial(_place_name, ended=True),
    "tunnel": partial(board, SQUARE, roads.tunnel, 0.74, 0.0, 0.04),
    "end-of-tunnel": partial(board, SQUARE, roads.tunnel, 0.74, 0.0, 0.04, ended=True),
    "pedestrian-crossing": partial(
        board, SQUARE, _triangle(at(people.on_crossing, 0.56, 0.0, 0.16)), 1.06, colours=PLAIN
    ),
    "cycle-crossing": partial(board, SQUARE, _triangle(at(vehicles.bicycle, 0.56, 0.0, 0.36)), 1.06, colours=PLAIN),
    "pedestrian-and-cycle-crossing": partial(board, SQUARE, _triangle(_crossing_with_bicycle), 1.06, colours=PLAIN),
    "hospital": partial(board, SQUARE, words("H", 1.3), 0.9),
    "hospital-with-emergency-ward": partial(board, SQUARE, _bed_and_cross, 0.82, colours={BLACK: WHITE}),
    "parking": partial(board, SQUARE, words("P", 1.4), 0.9),
    "parking-for-disabled-people": partial(board, UPRIGHT, _parking(at(people.wheelchair, 0.42, 0, 0.4)), 1.0),
    "parking-with-disc": partial(board, UPRIGHT, _parking(at(facilities.parking_disc, 0.4, 0, 0.46)), 1.0),
    "parking-on-the-footway": partial(board, UPRIGHT, _parking(_pavement_parking), 0.98),
    "park-and-ride": partial(
        board, SQUARE, several(fitted("P+R", 1.5, 0.84, 0, -0.34), at(vehicles.bus, 0.56, 0, 0.5)), 0.9
    ),
    "taxi-rank": partial(board, FLAT, fitted("TAXI", 1.6, 0.56), 1.0),
    "bus-stop": partial(_stop_post, vehicles.bus),
    "tram-stop": partial(_stop_post, vehicles.tram),
    "public-transport-stop": _round_stop,
    "emergency-stopping-place": partial(board, SQUARE, _lay_by, 0.86),
    "u-turn-permitted": partial(board, SQUARE, arrows.u_turn, 0.72),
    "speed-camera": partial(board, SQUARE, facilities.camera, 0.72),
    "advisory-speed": partial(board, SQUARE, words("60", 0.9), 0.95),
    "general-speed-limits": partial(board, UPRIGHT, _general_limits, 1.0, colours=PLAIN),
}
"""Makes the drawing of each key."""
