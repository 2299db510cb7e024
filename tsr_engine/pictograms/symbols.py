"""Symbols made of texts and of other signs: figures of limits, rings, discs and boards in small."""

from __future__ import annotations

from tsr_engine.pictograms.canvas import Canvas, Colour
from tsr_engine.pictograms.glyphs import text_width, write
from tsr_engine.pictograms.palette import BLACK, BLUE, RED, WHITE
from tsr_engine.pictograms.plates import ON_BLUE, Symbol


def words(text: str, height: float, x: float = 0.0, y: float = 0.0, squeeze: float = 1.0) -> Symbol:
    """A text, centred."""
    return lambda canvas: write(canvas, text, height, x, y, BLACK, squeeze)


def fitted(text: str, width: float, height: float, x: float = 0.0, y: float = 0.0, colour: Colour = BLACK) -> Symbol:
    """A text that is squeezed, if it must be, into a width."""
    squeeze = min(1.0, width / (text_width(text) * height))
    return lambda canvas: write(canvas, text, height, x, y, colour, squeeze)


def figure(text: str) -> Symbol:
    """The figure of a speed limit, for a ring of radius 1."""
    three = len(text) == 3
    return words(text, 0.66 if three else 0.76, 0, 0.01, 0.8 if three else 1.0)


def several(*symbols: Symbol) -> Symbol:
    """Symbols one over the other."""

    def symbol(canvas: Canvas) -> None:
        for each in symbols:
            each(canvas)

    return symbol


def at(
    symbol: Symbol, scale: float, x: float = 0.0, y: float = 0.0, *, mirror: bool = False, turn: float = 0.0
) -> Symbol:
    """A symbol at another place, of another size."""
    return lambda canvas: symbol(canvas.placed(scale, x, y, mirror=mirror, turn=turn))


def ring(symbol: Symbol) -> Symbol:
    """A prohibition in small: a symbol in a red ring of radius 1."""

    def small(canvas: Canvas) -> None:
        canvas.disc(0, 0, 1, RED)
        canvas.disc(0, 0, 0.77, WHITE)
        symbol(canvas)

    return small


def disc(symbol: Symbol) -> Symbol:
    """A command in small: a white symbol on a blue disc of radius 1."""

    def small(canvas: Canvas) -> None:
        canvas.disc(0, 0, 1, BLUE)
        symbol(canvas.placed(0.66, colours=ON_BLUE))

    return small


def stopping(bars: int, inscription: str = "") -> Symbol:
    """The disc of no parking (one bar) or no stopping (two bars), of radius 1."""

    def symbol(canvas: Canvas) -> None:
        canvas.disc(0, 0, 1, RED)
        canvas.disc(0, 0, 0.79, BLUE)
        if inscription:
            write(canvas, inscription, 0.86, 0, 0, WHITE)
        canvas.stroke("-62 -62 62 62", 0.19, RED)
        if bars == 2:
            canvas.stroke("-62 62 62 -62", 0.19, RED)

    return symbol


def countdown(bars: int, colour: Colour) -> Symbol:
    """Slanting bars above each other: one for each third of the way to what a board announces."""

    def symbol(canvas: Canvas) -> None:
        for k in range(bars):
            y = 27 * (bars - 1) - 54 * k - 13
            canvas.fill(f"-37 {y + 16} 37 {y - 16} 37 {y + 10} -37 {y + 42}", colour)

    return symbol


def plate(symbol: Symbol, width: float, height: float, ground: Colour = WHITE, edge: Colour | None = None) -> Symbol:
    """A rectangle with a symbol on it, about the origin."""

    def small(canvas: Canvas) -> None:
        w, h = round(width * 100), round(height * 100)
        if edge is not None:
            canvas.fill(f"{-w - 5} {-h - 5} {w + 5} {-h - 5} {w + 5} {h + 5} {-w - 5} {h + 5}", edge)
        canvas.fill(f"{-w} {-h} {w} {-h} {w} {h} {-w} {h}", ground)
        symbol(canvas)

    return small
