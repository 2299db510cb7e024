"""Section F: signs of information, facilities and services."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from tsr_engine.pictograms import facilities, people, vehicles
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.palette import WHITE
from tsr_engine.pictograms.plates import PLAIN, UPRIGHT, Symbol, board
from tsr_engine.pictograms.symbols import at, fitted, several


def _service(symbol: Symbol, scale: float = 0.46) -> Canvas:
    """A symbol on a white square in a blue upright board."""

    def on_square(canvas: Canvas) -> None:
        canvas.fill("-55 -80 55 -80 55 40 -55 40", WHITE)
        symbol(canvas.placed(scale, 0, -0.2))

    return board(UPRIGHT, on_square, 1.0, colours=PLAIN)


SERVICE: Final[dict[str, Callable[[], Canvas]]] = {
    "first-aid": partial(_service, facilities.red_cross),
    "breakdown-service": partial(_service, facilities.wrench, 0.44),
    "telephone": partial(_service, facilities.handset),
    "filling-station": partial(_service, facilities.fuel_pump),
    "charging-station": partial(_service, facilities.charging),
    "hotel": partial(_service, facilities.bed),
    "restaurant": partial(_service, facilities.fork_and_knife),
    "cafe": partial(_service, facilities.cup),
    "picnic-site": partial(_service, facilities.picnic),
    "starting-point-for-walks": partial(_service, people.hikers, 0.52),
    "camping-site": partial(_service, facilities.tent),
    "caravan-site": partial(_service, vehicles.caravan),
    "camping-and-caravan-site": partial(
        _service, several(at(facilities.tent, 0.5, -0.4, -0.42), at(vehicles.caravan, 0.62, 0.3, 0.52))
    ),
    "youth-hostel": partial(_service, facilities.house_and_tree),
    "tourist-information": partial(_service, facilities.information),
    "toilets": partial(_service, people.man_and_woman),
    "swimming": partial(_service, people.swimmer),
    "police-station": partial(_service, fitted("POLICE", 1.9, 0.6)),
    "emergency-telephone": partial(_service, facilities.sos),
    "fire-extinguisher": partial(_service, facilities.extinguisher),
}
"""Makes the drawing of each key."""
