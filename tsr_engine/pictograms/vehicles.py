"""Vehicles in black on white, each within the unit square, turned to the left where they have a front."""

from __future__ import annotations

from tsr_engine.pictograms import figures
from tsr_engine.pictograms.canvas import Canvas, Colour, arc
from tsr_engine.pictograms.palette import BLACK, ORANGE, RED, WHITE


def _wheel(canvas: Canvas, x: float, y: float, radius: float) -> None:
    """A wheel that stands out against a black body."""
    canvas.disc(x, y, radius * 1.28, WHITE)
    canvas.disc(x, y, radius, BLACK)


def _rimmed(canvas: Canvas, x: float, y: float, radius: float, tyre: float) -> None:
    """A wheel with a light rim."""
    canvas.disc(x, y, radius, BLACK)
    canvas.disc(x, y, radius - tyre, WHITE)


def car_front(canvas: Canvas) -> None:
    """A passenger car from the front."""
    for half in canvas.halves():
        half.fill("90 50 90 82 56 82 56 50", BLACK)
    canvas.fill(
        "-98 60 -98 8 Q -98 -10 -82 -14 L -62 -62 Q -58 -72 -46 -72 L 46 -72 Q 58 -72 62 -62 L 82 -14 Q 98 -10 98 8 L "
        "98 60",
        BLACK,
    )
    canvas.fill("-64 -16 -47 -56 47 -56 64 -16", WHITE)
    for x in (-0.7, 0.7):
        canvas.disc(x, 0.14, 0.15, WHITE)
    canvas.fill("-40 8 40 8 40 22 -40 22", WHITE)


def car_side(canvas: Canvas) -> None:
    """A passenger car from the side."""
    canvas.fill(
        "-100 26 Q -100 2 -84 -2 L -58 -8 -34 -42 Q -30 -48 -20 -48 L 34 -48 Q 46 -48 54 -38 L 76 -8 Q 98 -4 98 14 L "
        "98 30 -100 30",
        BLACK,
    )
    canvas.fill("-42 -8 -24 -36 2 -36 2 -8", WHITE)
    canvas.fill("12 -8 12 -36 34 -36 Q 42 -36 58 -8", WHITE)
    for x in (-0.56, 0.54):
        _wheel(canvas, x, 0.3, 0.19)


def car_rear(canvas: Canvas) -> None:
    """A passenger car from behind."""
    figures.car_rear(canvas, 0.0, 0.0, 1.9, BLACK)


def motorcycle(canvas: Canvas) -> None:
    """A motor cycle with its rider."""
    for x in (-0.62, 0.62):
        _rimmed(canvas, x, 0.48, 0.36, 0.13)
    canvas.stroke("-62 48 -34 -14", 0.1, BLACK, caps=True)
    canvas.stroke("-48 -22 -26 -16", 0.08, BLACK, caps=True)
    canvas.fill("-40 -12 Q -20 -18 -4 4 L 40 2 Q 66 -8 88 0 L 84 16 Q 64 12 58 40 L 20 56 -24 54 -34 20", BLACK)
    canvas.disc(-0.06, -0.78, 0.17, BLACK)
    canvas.fill("-2 -60 Q 22 -62 32 -40 L 44 4 8 8 2 -32", BLACK)
    canvas.stroke("8 -48 -12 -26 -40 -20", 0.13, BLACK, caps=True)
    canvas.stroke("22 2 -16 10 -6 48 -20 52", 0.15, BLACK, caps=True)


def moped(canvas: Canvas) -> None:
    """A moped without a rider."""
    for x in (-0.64, 0.64):
        _rimmed(canvas, x, 0.4, 0.33, 0.1)
    canvas.stroke("-64 40 -36 -34 -52 -42", 0.09, BLACK, caps=True)
    canvas.stroke("-42 -24 -28 14 0 34 64 40", 0.14, BLACK, caps=True)
    canvas.fill("-14 16 26 12 40 32 30 56 -8 56 -20 36", BLACK)
    canvas.stroke("20 30 34 -14", 0.09, BLACK)
    canvas.fill("12 -26 58 -30 Q 66 -22 58 -14 L 16 -12", BLACK)
    canvas.stroke("34 -8 92 2", 0.1, BLACK, caps=True)
    canvas.stroke("4 44 -14 66", 0.07, BLACK, caps=True)


def bicycle(canvas: Canvas) -> None:
    """A bicycle."""
    figures.bicycle(canvas.placed(2.35, 0, -0.62))


def lorry(canvas: Canvas) -> None:
    """A lorry from the side."""
    figures.lorry_side(canvas, 0.0, 0.0, 2.0, BLACK)


def lorry_with_trailer(canvas: Canvas) -> None:
    """A lorry with a trailer of two axles."""
    figures.lorry_side(canvas, -0.44, 0.0, 1.06, BLACK)
    canvas.fill("22 -33 98 -33 98 15 22 15", BLACK)
    canvas.stroke("8 18 98 18", 0.05, BLACK)
    for x in (0.38, 0.82):
        _wheel(canvas, x, 0.225, 0.09)


def car_with_trailer(canvas: Canvas) -> None:
    """A car that draws a trailer of one axle."""
    car_side(canvas.placed(0.62, -0.38, 0.0))
    canvas.stroke("20 17 40 17", 0.05, BLACK)
    canvas.fill("34 -10 98 -10 98 18 34 18", BLACK)
    _wheel(canvas, 0.66, 0.19, 0.12)


def tractor(canvas: Canvas) -> None:
    """An agricultural tractor."""
    canvas.fill("-86 -6 -18 -14 -18 40 -78 44 -86 40", BLACK)
    canvas.stroke("-58 -8 -58 -42", 0.08, BLACK)
    canvas.fill("-24 -16 -8 -76 60 -76 72 -10 72 30 -24 40", BLACK)
    canvas.fill("-8 -14 2 -64 48 -64 58 -14", WHITE)
    _wheel(canvas, 0.44, 0.3, 0.44)
    canvas.disc(0.44, 0.3, 0.13, WHITE)
    _wheel(canvas, -0.64, 0.5, 0.24)
    canvas.disc(-0.64, 0.5, 0.07, WHITE)


def bus(canvas: Canvas) -> None:
    """A bus from the side."""
    canvas.fill("-98 36 -98 0 -90 -50 Q -88 -58 -78 -58 L 90 -58 Q 98 -58 98 -50 L 98 36", BLACK)
    canvas.fill("-88 -2 -82 -42 -64 -42 -64 -2", WHITE)
    for left in (-54, -16, 22, 60):
        canvas.fill(f"{left} -2 {left} -42 {left + 28} -42 {left + 28} -2", WHITE)
    for x in (-0.56, 0.56):
        _wheel(canvas, x, 0.36, 0.18)


def tram(canvas: Canvas) -> None:
    """A tram from the side, on its rail, below the wire."""
    canvas.stroke("-58 -86 58 -86", 0.05, BLACK)
    canvas.stroke("-14 -42 14 -64 -10 -86", 0.06, BLACK, caps=True)
    canvas.fill("-92 44 -92 -8 -76 -42 76 -42 92 -8 92 44", BLACK)
    canvas.fill("-82 0 -70 -30 -52 -30 -52 0", WHITE)
    canvas.fill("82 0 70 -30 52 -30 52 0", WHITE)
    for left in (-42, -10, 22):
        canvas.fill(f"{left} 0 {left} -30 {left + 20} -30 {left + 20} 0", WHITE)
    for x in (-0.56, -0.3, 0.3, 0.56):
        _wheel(canvas, x, 0.5, 0.11)
    canvas.stroke("-98 68 98 68", 0.07, BLACK)


def locomotive(canvas: Canvas) -> None:
    """A steam engine."""
    canvas.fill("-86 -12 Q -92 8 -86 28 L 34 28 34 -12", BLACK)
    canvas.fill("-80 -10 -76 -40 -86 -54 -48 -54 -58 -40 -54 -10", BLACK)
    canvas.fill("-24 -10 Q -24 -32 -8 -32 8 -32 8 -10", BLACK)
    canvas.fill("22 28 22 -54 14 -54 14 -66 98 -66 98 -54 90 -54 90 28", BLACK)
    canvas.fill("40 -16 40 -44 74 -44 74 -16", WHITE)
    canvas.fill("-98 56 -78 24 90 24 90 44 -70 44 -74 56", BLACK)
    for x, radius in ((-0.56, 0.15), (-0.12, 0.21), (0.34, 0.21), (0.74, 0.15)):
        _wheel(canvas, x, 0.68 - radius, radius)


def aircraft(canvas: Canvas) -> None:
    """An aircraft in flight, seen from below, rising to the right."""
    plane = canvas.placed(1, turn=52)
    plane.fill("-11 -70 Q -11 -100 0 -100 11 -100 11 -70 L 11 78 0 98 -11 78", BLACK)
    plane.fill("-10 -34 -98 22 -98 42 -10 16 10 16 98 42 98 22 10 -34", BLACK)
    plane.fill("-9 52 -40 76 -40 92 0 80 40 92 40 76 9 52", BLACK)


def caravan(canvas: Canvas) -> None:
    """A caravan off its car."""
    canvas.fill("-72 34 -72 -22 Q -72 -54 -36 -54 L 62 -54 Q 96 -54 96 -22 L 96 34", BLACK)
    canvas.fill("-52 -4 -52 -34 0 -34 0 -4", WHITE)
    canvas.fill("34 34 34 -34 68 -34 68 34", WHITE)
    canvas.stroke("-98 30 -60 30", 0.07, BLACK)
    canvas.stroke("-90 30 -90 52", 0.06, BLACK)
    _wheel(canvas, 0.06, 0.36, 0.17)


def dangerous_load(canvas: Canvas) -> None:
    """A lorry from behind with the orange plate of dangerous goods."""
    figures.lorry_rear(canvas, 0.0, 0.22, 1.5, BLACK)
    canvas.fill("-44 -46 44 -46 44 6 -44 6", ORANGE)


def exploding_load(canvas: Canvas) -> None:
    """A vehicle whose load bursts."""
    _burst(canvas, RED)
    figures.car_rear(canvas, 0.0, 0.3, 1.1, BLACK)


def _burst(canvas: Canvas, colour: Colour) -> None:
    canvas.fill("-70 10 -46 -14 -84 -40 -44 -40 -56 -86 -22 -58 0 -98 22 -58 56 -86 44 -40 84 -40 46 -14 70 10", colour)


def polluting_load(canvas: Canvas) -> None:
    """A tank lorry above waves."""
    canvas.fill("-98 20 -98 -10 -86 -40 -56 -40 -56 20", BLACK)
    canvas.fill("-88 -10 -80 -30 -64 -30 -64 -10", WHITE)
    canvas.fill("-46 -46 82 -46 Q 98 -46 98 -20 98 8 82 8 L -46 8", BLACK)
    canvas.fill("-98 10 98 10 98 22 -98 22", BLACK)
    for x in (-0.74, 0.36, 0.72):
        _wheel(canvas, x, 0.26, 0.14)
    for y in (0.58, 0.8):
        waves(canvas, y, 0.1)


def waves(canvas: Canvas, y: float, width: float, colour: Colour = BLACK) -> None:
    """A wavy line from side to side at a height."""
    low = round(y * 100)
    text = f"-96 {low} Q -72 {low - 22} -48 {low} -24 {low + 22} 0 {low} 24 {low - 22} 48 {low} 72 {low + 22} 96 {low}"
    canvas.stroke(text, width, colour)


def cart_wheel(canvas: Canvas, x: float, y: float, radius: float) -> None:
    """A wheel with spokes."""
    _rimmed(canvas, x, y, radius, 0.09)
    for turn in (0, 60, 120):
        canvas.placed(radius, x, y, turn=turn).stroke("-90 0 90 0", 0.05 / radius, BLACK)
    canvas.disc(x, y, 0.08, BLACK)


def snow_chain(canvas: Canvas) -> None:
    """A tyre with a snow chain."""
    canvas.disc(0, 0, 0.98, BLACK)
    canvas.disc(0, 0, 0.56, WHITE)
    for k in range(8):
        spoke = canvas.placed(1, turn=45 * k)
        spoke.stroke("-13 -100 13 -56", 0.075, WHITE)
        spoke.stroke("13 -100 -13 -56", 0.075, WHITE)
    canvas.stroke(arc(0, 0, 0.56, 0.56, 0, 360, 60), 0.06, BLACK)
    canvas.disc(0, 0, 0.2, BLACK)
