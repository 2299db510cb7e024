"""Section H: additional panels."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import arrows, figures, people, vehicles
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.figures import arrow
from tsr_engine.pictograms.palette import BLACK, WHITE
from tsr_engine.pictograms.plates import Symbol, board
from tsr_engine.pictograms.symbols import at, fitted, several

_FLAT: Final = (0.98, 0.5)
_TALL: Final = (0.36, 0.9)


def _panel(symbol: Symbol, scale: float = 0.9, size: tuple[float, float] = _FLAT, *, mirror: bool = False) -> Canvas:
    return board(size, symbol, scale, ground=WHITE, rim=BLACK, mirror=mirror)


def _length(canvas: Canvas) -> None:
    """A length between two arrows up."""
    for x in (-0.86, 0.86):
        arrow(canvas.placed(1, x), "0 36 0 -38", 0.07, 0.2, BLACK)
    fitted("800 m", 1.3, 0.5)(canvas)


def _pole(text: str) -> Symbol:
    """Arrows that stand upright: where a rule begins, goes on, ends."""

    def symbol(canvas: Canvas) -> None:
        if "up" in text:
            arrow(canvas, "0 20 0 -84", 0.16, 0.44, BLACK)
        if "down" in text:
            arrow(canvas, "0 -20 0 84", 0.16, 0.44, BLACK)
        if text == "up":
            canvas.stroke("0 10 0 84", 0.16, BLACK)
        if text == "down":
            canvas.stroke("0 -10 0 -84", 0.16, BLACK)

    return symbol


def _across(text: str) -> Symbol:
    """Arrows that lie along the road."""

    def symbol(canvas: Canvas) -> None:
        fitted("10 m", 0.9, 0.34, 0, -0.2)(canvas)
        line = canvas.placed(1, 0, 0.24)
        if text in ("right", "both"):
            arrow(line, "-60 0 90 0", 0.1, 0.3, BLACK)
        if text in ("left", "both"):
            arrow(line, "60 0 -90 0", 0.1, 0.3, BLACK)

    return symbol


def _main_road(canvas: Canvas) -> None:
    """A junction: the main road bends broadly to the left, minor ones are thin."""
    canvas.stroke("0 92 0 20 Q 0 -8 -28 -8 L -92 -8", 0.3, BLACK)
    canvas.stroke("0 -14 0 -92", 0.11, BLACK)
    canvas.stroke("10 -2 92 -2", 0.11, BLACK)


def _snow(canvas: Canvas) -> None:
    figures.snowflake(canvas.placed(2.9, 0, -0.58))


def _except(symbol: Symbol) -> Symbol:
    return several(fitted("EXCEPT", 1.3, 0.32, 0, -0.28), at(symbol, 0.36, 0, 0.2))


PANELS: Final[dict[str, Callable[[], Canvas]]] = {
    "distance-panel": partial(_panel, fitted("200 m", 1.6, 0.56)),
    "length-panel": partial(_panel, _length),
    "parking-rule-begins": partial(_panel, _across("right")),
    "parking-rule-goes-on": partial(_panel, _across("both")),
    "parking-rule-ends": partial(_panel, _across("left")),
    "upright-arrow-up": partial(_panel, _pole("up"), 1.0, _TALL),
    "upright-arrows-both-ways": partial(_panel, _pole("up down"), 1.0, _TALL),
    "upright-arrow-down": partial(_panel, _pole("down"), 1.0, _TALL),
    "arrow-panel-right": partial(_panel, arrows.arrow_right, 0.5),
    "arrow-panel-left": partial(_panel, arrows.arrow_right, 0.5, mirror=True),
    "arrow-panel-both-ways": partial(_panel, arrows.arrow_both, 0.6),
    "lorry-panel": partial(_panel, vehicles.lorry, 0.54),
    "car-panel": partial(_panel, vehicles.car_side, 0.68),
    "motorcycle-panel": partial(_panel, vehicles.motorcycle, 0.42),
    "bicycle-panel": partial(_panel, vehicles.bicycle, 0.62),
    "bus-panel": partial(_panel, vehicles.bus, 0.6),
    "except-cyclists-panel": partial(_panel, _except(at(vehicles.bicycle, 1.2))),
    "disabled-panel": partial(_panel, people.wheelchair, 0.42),
    "main-road-panel": partial(_panel, _main_road, 0.8, (0.86, 0.86)),
    "ice-panel": partial(_panel, _snow, 0.42),
    "time-panel": partial(_panel, fitted("16-18 h", 1.7, 0.5)),
    "weight-panel": partial(_panel, fitted("7.5 t", 1.4, 0.58)),
}
"""Makes the drawing of each key."""
