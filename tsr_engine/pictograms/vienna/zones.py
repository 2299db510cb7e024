"""Section E: signs of zones, their beginnings and their ends."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import people, vehicles
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.palette import BLACK, BLUE, WHITE
from tsr_engine.pictograms.plates import FADED, ON_BLUE, PLAIN, UPRIGHT, Symbol, board, end_stripes
from tsr_engine.pictograms.symbols import at, disc, figure, fitted, plate, ring, several, stopping, words

ZONE_SPEEDS: Final = (20, 30, 40)
"""Limits that are common in zones."""


def _zone(sign: Symbol, word: str = "ZONE") -> Symbol:
    return several(at(sign, 0.52, 0, -0.32), fitted(word, 1.1, 0.32, 0, 0.58))


def _begins(symbol: Symbol) -> Canvas:
    return board(UPRIGHT, symbol, 1.0, ground=WHITE, rim=BLACK, colours=PLAIN)


def _ends(symbol: Symbol) -> Canvas:
    def faded(canvas: Canvas) -> None:
        symbol(canvas.placed(1, colours=FADED))
        end_stripes(canvas, UPRIGHT[0] - 0.045, UPRIGHT[1] - 0.045)

    return board(UPRIGHT, faded, 1.0, ground=WHITE, rim=BLACK, colours=PLAIN)


def _white_on_blue(symbol: Symbol) -> Symbol:
    return plate(lambda canvas: symbol(canvas.placed(0.8, colours=ON_BLUE)), 0.96, 0.96, BLUE)


_PARKING = _white_on_blue(words("P", 1.6))
_ZONES: Final[dict[str, Symbol]] = {
    "no-parking-zone": _zone(stopping(1)),
    "no-stopping-zone": _zone(stopping(2)),
    "parking-zone": _zone(_PARKING),
    **{f"speed-limit-zone-{speed}": _zone(ring(figure(str(speed)))) for speed in ZONE_SPEEDS},
    "pedestrian-zone": _zone(disc(people.adult_and_child)),
    "low-emission-zone": several(
        at(ring(fitted("UMWELT", 1.3, 0.36)), 0.52, 0, -0.32), fitted("ZONE", 1.1, 0.32, 0, 0.58)
    ),
    "cycle-street": _zone(disc(vehicles.bicycle), "CYCLE"),
}

ZONES: Final[dict[str, Callable[[], Canvas]]] = {
    **{key: partial(_begins, symbol) for key, symbol in _ZONES.items()},
    **{f"end-of-{key}": partial(_ends, symbol) for key, symbol in _ZONES.items()},
    "residential-area": partial(board, (0.98, 0.72), people.children_at_play, 0.72, 0.0, 0.0),
    "end-of-residential-area": partial(board, (0.98, 0.72), people.children_at_play, 0.72, 0.0, 0.0, ended=True),
}
"""Makes the drawing of each key."""
