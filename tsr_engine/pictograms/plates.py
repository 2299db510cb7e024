"""The faces of signs that symbols are drawn on: triangles, rings, discs and boards, each with its silhouette."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from tsr_engine.pictograms.canvas import Canvas, Colour, arc, regular, rounded
from tsr_engine.pictograms.palette import BLACK, BLUE, GREY, PALE, RED, WHITE
from tsr_engine.pictograms.paths import Points

Symbol = Callable[[Canvas], None]
"""Draws what a sign shows, on a canvas whose unit is about half the symbol's width."""

ON_BLUE: Mapping[Colour, Colour] = {BLACK: WHITE, WHITE: BLUE}
"""Exchanges colours of a black symbol on white for white on blue."""
FADED: Mapping[Colour, Colour] = {BLACK: GREY, RED: GREY, BLUE: PALE}
"""Exchanges colours for those of a sign whose rule ends."""

PLAIN: Mapping[Colour, Colour] = {}
"""Exchanges nothing."""
SQUARE = (0.98, 0.98)
UPRIGHT = (0.7, 0.98)
FLAT = (0.98, 0.49)


def triangle(radius: float, corner: float, *, up: bool) -> Points:
    """A rounded equilateral triangle of a circumradius, centred in its box."""
    sign = -1 if up else 1
    corners = regular(3, radius, -90 if up else 90)
    return np.asarray(rounded(corners, corner) + np.array([0.0, -sign * np.sqrt(3) / 6]))


def rectangle(width: float, height: float, corner: float = 0.08) -> Points:
    """A rounded rectangle about the origin, of half a width and half a height."""
    w, h = width, height
    return rounded(np.array([(-w, -h), (w, -h), (w, h), (-w, h)], np.float64), corner)


def round_face() -> Points:
    """The silhouette of a round sign."""
    return arc(0, 0, 1, 1, 0, 360, 181)[:-1]


def red_ring(canvas: Canvas) -> None:
    """The face of a prohibition."""
    canvas.disc(0, 0, 1.1, WHITE)
    canvas.disc(0, 0, 0.955, RED)
    canvas.disc(0, 0, 0.735, WHITE)


def blue_disc(canvas: Canvas) -> None:
    """The face of a command: blue with a white rim."""
    canvas.disc(0, 0, 1.1, WHITE)
    canvas.disc(0, 0, 0.955, BLUE)


def end_ring(canvas: Canvas) -> None:
    """The face of an end: white in a thin dark ring."""
    canvas.disc(0, 0, 1.1, WHITE)
    canvas.disc(0, 0, 0.975, BLACK)
    canvas.disc(0, 0, 0.93, WHITE)


def end_bars(canvas: Canvas, reach: float = 0.93, colour: Colour = BLACK) -> None:
    """Five bars from lower left to upper right, within a circle."""
    across = np.array([1.0, 1.0]) / np.sqrt(2)
    along = np.array([1.0, -1.0]) / np.sqrt(2)
    for k in (-2, -1, 0, 1, 2):
        shift = across * 0.095 * k
        length = np.sqrt(reach**2 - (0.095 * k) ** 2)
        canvas.stroke(np.stack([shift - along * length, shift + along * length]), 0.052, colour)


def warning_face(canvas: Canvas) -> None:
    """The face of a danger warning: white in a red border."""
    canvas.fill(np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float), WHITE)
    canvas.fill(triangle(1.07, 0.08, up=True), RED)
    canvas.fill(triangle(0.765, 0.05, up=True), WHITE)


def danger(symbol: Symbol, scale: float = 0.36, dx: float = 0.0, dy: float = 0.29, *, mirror: bool = False) -> Canvas:
    """A danger warning.

    Args:
        symbol: what it shows.
        scale: unit of the symbol on the sign.
        dx: its origin, right.
        dy: its origin, down.
        mirror: the symbol is turned left to right.
    """
    canvas = Canvas()
    warning_face(canvas)
    symbol(canvas.placed(scale, dx, dy, mirror=mirror))
    canvas.outline(triangle(2 / np.sqrt(3), 0.1, up=True))
    return canvas


def prohibition(
    symbol: Symbol, scale: float = 0.55, dx: float = 0.0, dy: float = 0.0, *, bar: bool = False, mirror: bool = False
) -> Canvas:
    """A prohibition: a symbol in a red ring, crossed by a red bar where ``bar``."""
    canvas = Canvas()
    red_ring(canvas)
    symbol(canvas.placed(scale, dx, dy, mirror=mirror))
    if bar:
        canvas.stroke(np.array([(-0.57, -0.57), (0.57, 0.57)]), 0.15, RED)
    canvas.outline(round_face())
    return canvas


def end_of(symbol: Symbol, scale: float = 0.6, dx: float = 0.0, dy: float = 0.0) -> Canvas:
    """The end of a prohibition: its symbol in grey under black bars."""
    canvas = Canvas()
    end_ring(canvas)
    symbol(canvas.placed(scale, dx, dy, colours=FADED))
    end_bars(canvas)
    canvas.outline(round_face())
    return canvas


def mandatory(
    symbol: Symbol,
    scale: float = 0.62,
    dx: float = 0.0,
    dy: float = 0.0,
    *,
    ended: bool = False,
    mirror: bool = False,
) -> Canvas:
    """A command: a white symbol on a blue disc, crossed by a red bar where it is ``ended``.

    The symbol is drawn in black on white; its colours are exchanged here.
    """
    canvas = Canvas()
    blue_disc(canvas)
    symbol(canvas.placed(scale, dx, dy, colours=ON_BLUE, mirror=mirror))
    if ended:
        reach = 0.955 / math.sqrt(2)
        canvas.stroke(np.array([(-reach, reach), (reach, -reach)]), 0.16, RED)
    canvas.outline(round_face())
    return canvas


def board(
    size: tuple[float, float],
    symbol: Symbol,
    scale: float = 0.6,
    dx: float = 0.0,
    dy: float = 0.0,
    *,
    ground: Colour = BLUE,
    rim: Colour = WHITE,
    colours: Mapping[Colour, Colour] | None = None,
    ended: bool = False,
    mirror: bool = False,
) -> Canvas:
    """A rectangular sign.

    Args:
        size: half its width and half its height.
        symbol: what it shows, drawn in black on white.
        scale: unit of the symbol on the sign.
        dx: its origin, right.
        dy: its origin, down.
        ground: colour of the ground.
        rim: colour of the thin line around it.
        colours: exchanges colours of the symbol; None: white on a dark ground, else black on the ground.
        ended: a red bar crosses it from upper right to lower left.
        mirror: the symbol is turned left to right.
    """
    width, height = size
    if colours is None:
        dark = sum(ground) < 400
        colours = {BLACK: WHITE, WHITE: ground} if dark else {WHITE: ground}
    canvas = Canvas()
    canvas.fill(rectangle(width + 0.1, height + 0.1), rim)
    canvas.fill(rectangle(width - 0.045, height - 0.045, 0.06), ground)
    symbol(canvas.placed(scale, dx, dy, colours=colours, mirror=mirror))
    if ended:
        slash(canvas, width - 0.045, height - 0.045, 0.17, RED)
    canvas.outline(rectangle(width, height))
    return canvas


def slash(canvas: Canvas, width: float, height: float, thickness: float, colour: Colour) -> None:
    """A bar from the upper right to the lower left corner of a rectangle, cut off at its edges."""
    length = math.hypot(width, height)
    up, along = thickness / 2 * length / width, thickness / 2 * length / height
    w, h = width, height
    corners = [(-w, h), (-w, h - up), (w - along, -h), (w, -h), (w, -h + up), (-w + along, h)]
    canvas.fill(np.array(corners, np.float64), colour)


def end_stripes(canvas: Canvas, width: float, height: float, colour: Colour = BLACK) -> None:
    """Three thin bars from the lower left to the upper right of a rectangle, cut off at its edges."""
    length = math.hypot(width, height)
    along = np.array([width, -height]) / length
    across = np.array([height, width]) / length
    box = np.array([width, height])
    for k in (-1, 0, 1):
        middle = across * 0.11 * k
        reach = [min((box - middle * turn) / np.abs(along)) for turn in (np.sign(along), -np.sign(along))]
        canvas.stroke(np.stack([middle - along * reach[1], middle + along * reach[0]]), 0.045, colour)
