"""Section C: prohibitory and restrictive signs that the German 43 lack."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import arrows, facilities, people, vehicles
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.glyphs import write
from tsr_engine.pictograms.palette import BLACK, WHITE
from tsr_engine.pictograms.plates import end_of, prohibition, round_face
from tsr_engine.pictograms.symbols import at, figure, fitted, several, stopping

SPEEDS: Final = (5, 10, 15, 25, 35, 40, 45, 55, 65, 75, 90, 95, 110, 130, 140)
"""Limits beside those of the German 43."""
ENDED_SPEEDS: Final = (20, 30, 40, 50, 60, 70, 90, 100, 110, 120, 130)
"""Limits whose ends are signs, beside that of 80."""


def _stopping(bars: int, inscription: str = "") -> Canvas:
    canvas = Canvas()
    canvas.disc(0, 0, 1.1, WHITE)
    stopping(bars, inscription)(canvas.placed(0.955))
    canvas.outline(round_face())
    return canvas


def _lorry_over(weight: str) -> Canvas:
    def symbol(canvas: Canvas) -> None:
        vehicles.lorry(canvas)
        write(canvas, weight, 0.44, 0.3, -0.17, WHITE, 0.78)

    return prohibition(symbol, 0.6, 0.0, 0.03)


def _between_walls(canvas: Canvas) -> None:
    """Two arrowheads that point inwards from the sides: a width."""
    for half in canvas.halves():
        half.fill("70 -17 70 17 46 0", BLACK)


def _between_floors(canvas: Canvas) -> None:
    """Two arrowheads that point inwards from above and below: a height."""
    for turn in (90, -90):
        canvas.placed(1, turn=turn).fill("70 -17 70 17 46 0", BLACK)


def _axle(canvas: Canvas) -> None:
    """A pair of wheels on an axle with an arrow down on it."""
    canvas.fill("-12 -70 12 -70 12 -60 0 -44 -12 -60", BLACK)
    canvas.stroke("-34 46 34 46", 0.07, BLACK)
    for half in canvas.halves():
        half.fill("26 30 42 30 42 62 26 62", BLACK)


def _length(canvas: Canvas) -> None:
    """A lorry over a line with heads at both ends."""
    vehicles.lorry(canvas.placed(0.5, 0, -0.26))
    canvas.stroke("-52 14 52 14", 0.05, BLACK)
    for half in canvas.halves():
        half.fill("62 14 46 4 46 24", BLACK)


def _gap(canvas: Canvas) -> None:
    """Two cars behind each other, with a distance between them."""
    for x in (-0.36, 0.36):
        vehicles.car_side(canvas.placed(0.25, x, 0.22))
    for half in canvas.halves():
        half.fill("4 -2 22 -12 22 8", BLACK)


def _checkpoint(upper: str, lower: str) -> Canvas:
    def symbol(canvas: Canvas) -> None:
        canvas.fill("-68 -7 68 -7 68 7 -68 7", BLACK)
        fitted(upper, 0.9, 0.28, 0, -0.28)(canvas)
        fitted(lower, 0.9, 0.28, 0, 0.29)(canvas)

    return prohibition(symbol, 1.0)


def _bent(canvas: Canvas) -> None:
    """An arrow from below that turns to the left."""
    arrows.turn_left(canvas.placed(1, -0.1, 0.08))


PROHIBITORY: Final[dict[str, Callable[[], Canvas]]] = {
    "no-cars": partial(prohibition, vehicles.car_front, 0.5),
    "no-motorcycles": partial(prohibition, vehicles.motorcycle, 0.56),
    "no-bicycles": partial(prohibition, vehicles.bicycle, 0.62),
    "no-mopeds": partial(prohibition, vehicles.moped, 0.58, 0.0, -0.04),
    "no-buses": partial(prohibition, vehicles.bus, 0.58),
    "no-lorries-over-3-5-t": partial(_lorry_over, "3.5t"),
    "no-lorries-over-7-5-t": partial(_lorry_over, "7.5t"),
    "no-lorries-with-trailers": partial(prohibition, vehicles.lorry_with_trailer, 0.71),
    "no-trailers": partial(prohibition, vehicles.car_with_trailer, 0.71),
    "no-dangerous-goods": partial(prohibition, vehicles.dangerous_load, 0.5, 0.0, -0.02),
    "no-explosives": partial(prohibition, vehicles.exploding_load, 0.56, 0.0, 0.06),
    "no-water-polluting-goods": partial(prohibition, vehicles.polluting_load, 0.56, 0.0, -0.06),
    "no-pedestrians": partial(prohibition, people.walker, 0.56),
    "no-horse-riders": partial(prohibition, people.rider, 0.58, 0.0, -0.02),
    "no-animal-drawn-vehicles": partial(prohibition, people.horse_cart, 0.64, 0.0, -0.02),
    "no-handcarts": partial(prohibition, people.handcart, 0.58),
    "no-tractors": partial(prohibition, vehicles.tractor, 0.54),
    "no-motor-vehicles": partial(
        prohibition, several(at(vehicles.motorcycle, 0.44, 0, -0.42), at(vehicles.car_front, 0.5, 0, 0.5)), 0.7
    ),
    "no-motor-or-animal-drawn-vehicles": partial(
        prohibition, several(at(vehicles.car_front, 0.42, 0, -0.5), at(people.horse_cart, 0.78, 0, 0.26)), 0.68
    ),
    "width-limit": partial(prohibition, several(_between_walls, fitted("2 m", 0.78, 0.46)), 1.0),
    "height-limit": partial(prohibition, several(_between_floors, fitted("3.5 m", 1.15, 0.5)), 1.0),
    "weight-limit": partial(prohibition, fitted("5.5 t", 1.15, 0.62), 1.0),
    "axle-load-limit": partial(prohibition, several(_axle, fitted("2.4 t", 0.95, 0.46, 0, -0.08)), 1.0),
    "length-limit": partial(prohibition, several(_length, fitted("10 m", 0.7, 0.34, 0, 0.42)), 1.0),
    "minimum-distance": partial(prohibition, several(_gap, fitted("70 m", 0.8, 0.34, 0, -0.32)), 1.0),
    "no-left-turn": partial(prohibition, _bent, 0.6, bar=True),
    "no-right-turn": partial(prohibition, _bent, 0.6, bar=True, mirror=True),
    "no-straight-ahead": partial(prohibition, arrows.arrow_up, 0.58, bar=True),
    "no-u-turn": partial(prohibition, arrows.u_turn, 0.5, 0.0, 0.02, bar=True),
    "no-horn": partial(prohibition, facilities.horn, 0.58, bar=True),
    "customs": partial(_checkpoint, "ZOLL", "DOUANE"),
    "police-checkpoint": partial(_checkpoint, "HALT", "POLIZEI"),
    "toll-checkpoint": partial(_checkpoint, "MAUT", "PEAGE"),
    "no-parking": partial(_stopping, 1),
    "no-stopping": partial(_stopping, 2),
    "no-parking-on-odd-days": partial(_stopping, 1, "I"),
    "no-parking-on-even-days": partial(_stopping, 1, "II"),
    **{f"speed-limit-{speed}": partial(prohibition, figure(str(speed)), 1.0) for speed in SPEEDS},
    **{
        f"end-of-speed-limit-{speed}": partial(end_of, figure(str(speed)), 1.13 if speed < 100 else 1.1)
        for speed in ENDED_SPEEDS
    },
}
"""Makes the drawing of each key."""
