"""Section D: mandatory signs that the German 43 lack."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import arrows, people, vehicles
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.palette import BLACK, ORANGE
from tsr_engine.pictograms.plates import ON_BLUE, SQUARE, Symbol, board, mandatory
from tsr_engine.pictograms.symbols import at, figure, several

MINIMUM_SPEEDS: Final = (30, 40, 50, 60, 70, 80)
"""Least speeds that are commanded."""


def _split(left: Symbol, right: Symbol) -> Symbol:
    """Two symbols side by side with a line between them."""

    def symbol(canvas: Canvas) -> None:
        left(canvas.placed(0.58, -0.62, 0))
        right(canvas.placed(0.58, 0.62, 0))
        canvas.stroke("0 -140 0 140", 0.09, BLACK)

    return symbol


def _stacked(upper: Symbol, lower: Symbol) -> Symbol:
    return several(at(upper, 0.68, 0, -0.62), at(lower, 0.72, 0, 0.7))


def _goods_route(direction: Symbol, *, mirror: bool = False) -> Canvas:
    """A lorry with the orange plate above an arrow."""

    def symbol(canvas: Canvas) -> None:
        truck = canvas.placed(0.62, 0, -0.42)
        vehicles.lorry(truck.placed(1, colours=ON_BLUE))
        truck.fill("-20 -46 76 -46 76 12 -20 12", ORANGE)
        direction(canvas.placed(0.4, 0, 0.48, mirror=mirror, colours=ON_BLUE))

    return board(SQUARE, symbol, 1.0, colours={})


def _cyclist_path(canvas: Canvas) -> None:
    vehicles.bicycle(canvas.placed(1.1))


MANDATORY: Final[dict[str, Callable[[], Canvas]]] = {
    "turn-right-here": partial(mandatory, arrows.arrow_right, 0.72),
    "turn-left-here": partial(mandatory, arrows.arrow_right, 0.72, mirror=True),
    "turn-left-or-right": partial(mandatory, arrows.fork_arrow, 0.7),
    "pass-either-side": partial(mandatory, arrows.pass_either_side, 0.72, 0.0, 0.06),
    "cycle-track": partial(mandatory, vehicles.bicycle, 0.8),
    "footpath": partial(mandatory, people.adult_and_child, 0.66),
    "bridle-path": partial(mandatory, people.rider, 0.7, 0.0, -0.02),
    "shared-path": partial(mandatory, _stacked(people.adult_and_child, vehicles.bicycle), 0.68),
    "separate-path-cyclists-left": partial(mandatory, _split(_cyclist_path, people.adult_and_child), 0.66),
    "separate-path-pedestrians-left": partial(mandatory, _split(people.adult_and_child, _cyclist_path), 0.66),
    "end-of-cycle-track": partial(mandatory, vehicles.bicycle, 0.8, ended=True),
    "end-of-footpath": partial(mandatory, people.adult_and_child, 0.66, ended=True),
    "end-of-shared-path": partial(mandatory, _stacked(people.adult_and_child, vehicles.bicycle), 0.68, ended=True),
    "buses-only": partial(mandatory, vehicles.bus, 0.7),
    **{f"minimum-speed-{speed}": partial(mandatory, figure(str(speed)), 1.2) for speed in MINIMUM_SPEEDS},
    **{
        f"end-of-minimum-speed-{speed}": partial(mandatory, figure(str(speed)), 1.2, ended=True)
        for speed in MINIMUM_SPEEDS[:4]
    },
    "snow-chains": partial(mandatory, vehicles.snow_chain, 0.62),
    "dangerous-goods-straight-ahead": partial(_goods_route, arrows.arrow_up),
    "dangerous-goods-left": partial(_goods_route, arrows.arrow_right, mirror=True),
    "dangerous-goods-right": partial(_goods_route, arrows.arrow_right),
}
"""Makes the drawing of each key."""
