"""People and animals in black on white, each within the unit square, turned to the left."""

from __future__ import annotations

from tsr_engine.pictograms import figures
from tsr_engine.pictograms.canvas import Canvas, arc
from tsr_engine.pictograms.palette import BLACK, WHITE
from tsr_engine.pictograms.vehicles import car_side, cart_wheel


def walker(canvas: Canvas) -> None:
    """A walking man."""
    figures.walker(canvas, 1.7, 0.0, -0.12)


def adult_and_child(canvas: Canvas) -> None:
    """A woman with a child by the hand."""
    canvas.disc(0.2, -0.76, 0.17, BLACK)
    canvas.fill(
        "4 -54 Q 20 -60 38 -54 L 50 -10 62 34 42 34 46 94 30 94 24 40 10 40 4 94 -12 94 -2 34 -18 34 -4 -14",
        BLACK,
    )
    canvas.stroke("44 -44 64 -8 58 16", 0.1, BLACK, caps=True)
    canvas.stroke("2 -44 -18 -14 -30 18", 0.1, BLACK, caps=True)
    child = canvas.placed(1, -0.52, 0.3)
    child.disc(0, -0.3, 0.13, BLACK)
    child.fill("-12 -14 12 -14 18 26 10 26 10 64 -1 64 -1 30 -4 30 -8 64 -19 64 -16 26 -18 26", BLACK)
    child.stroke("10 -10 24 -12", 0.08, BLACK, caps=True)
    child.stroke("-12 -8 -26 14", 0.08, BLACK, caps=True)


def on_crossing(canvas: Canvas) -> None:
    """A man who walks over a striped crossing."""
    for k in range(5):
        x = -92 + 40 * k
        canvas.fill(f"{x} 96 {x + 24} 96 {x + 24 - (x + 12) * 0.24:.1f} 56 {x - (x + 12) * 0.24:.1f} 56", BLACK)
    man = canvas.placed(1.0)
    figures.walker(man.placed(1, colours={BLACK: WHITE}), 1.38, 0.0, -0.18)
    figures.walker(man, 1.28, 0.0, -0.16)


def wheelchair(canvas: Canvas) -> None:
    """A person in a wheelchair."""
    canvas.disc(-0.18, -0.8, 0.17, BLACK)
    canvas.stroke("-18 -58 -10 8 38 8 58 72 78 66", 0.16, BLACK, caps=True)
    canvas.stroke("-14 -28 32 -28", 0.12, BLACK, caps=True)
    canvas.stroke(arc(-0.02, 0.4, 0.52, 0.52, 22, 232, 30), 0.12, BLACK, caps=True)


def swimmer(canvas: Canvas) -> None:
    """A swimmer above waves."""
    canvas.disc(-0.62, -0.1, 0.19, BLACK)
    canvas.stroke("-26 6 -2 -40 -44 -56", 0.16, BLACK, caps=True)
    canvas.fill("-34 14 -4 -34 20 -26 78 10", BLACK)
    for y in (0.38, 0.7):
        low = round(y * 100)
        line = (
            f"-96 {low} Q -72 {low - 24} -48 {low} -24 {low + 24} 0 {low} 24 {low - 24} 48 {low} 72 {low + 24} 96 {low}"
        )
        canvas.stroke(line, 0.12, BLACK)


def man_and_woman(canvas: Canvas) -> None:
    """A man and a woman side by side: lavatories."""
    man = canvas.placed(1, -0.48)
    man.disc(0, -0.78, 0.17, BLACK)
    man.fill(
        "-24 -56 24 -56 34 -48 34 10 22 10 22 -28 18 -28 18 94 3 94 3 22 -3 22 -3 94 -18 94 -18 -28 -22 -28 -22 10 -34 "
        "10 -34 -48",
        BLACK,
    )
    woman = canvas.placed(1, 0.5)
    woman.disc(0, -0.78, 0.17, BLACK)
    woman.fill(
        "-16 -56 16 -56 Q 24 -54 28 -44 L 46 6 36 12 20 -26 36 44 16 44 16 94 3 94 3 44 -3 44 -3 94 -16 94 -16 44 -36 "
        "44 -20 -26 -36 12 -46 6 -28 -44 Q -24 -54 -16 -56",
        BLACK,
    )
    canvas.stroke("0 -92 0 92", 0.05, BLACK)


def hikers(canvas: Canvas) -> None:
    """Two walkers with rucksack and stick."""
    for scale, x, y in ((1.35, -0.36, -0.02), (1.35, 0.46, -0.02)):
        figures.walker(canvas, scale, x, y)
        one = canvas.placed(scale, x, y)
        one.fill("12 -24 26 -22 27 6 12 8", BLACK)
        one.stroke("-20 8 -32 58", 0.045, BLACK)


def running_out(canvas: Canvas) -> None:
    """A man who runs out of a door: emergency exit."""
    canvas.fill("-98 -92 -26 -92 -26 92 -98 92", BLACK)
    man = canvas.placed(1, 0.16, 0.0)
    man.placed(1, colours={BLACK: WHITE}).stroke("-2 -36 -44 -28 -62 -52", 0.22, BLACK, caps=True)
    man.disc(-0.1, -0.68, 0.18, BLACK)
    man.stroke("-2 -36 14 10", 0.3, BLACK, caps=True)
    man.stroke("8 14 -26 34 -22 78", 0.17, BLACK, caps=True)
    man.stroke("14 14 38 48 72 54", 0.17, BLACK, caps=True)
    man.stroke("6 -36 40 -14 62 -36", 0.12, BLACK, caps=True)
    man.stroke("-8 -36 -40 -26 -52 -46", 0.12, BLACK, caps=True)


def stairs_down(canvas: Canvas) -> None:
    """A man on stairs."""
    canvas.fill(
        "-98 92 -98 70 -60 70 -60 44 -22 44 -22 18 16 18 16 -8 54 -8 54 -34 98 -34 98 -6 78 -6 78 20 40 20 40 46 2 46 "
        "2 72 -36 72 -36 92",
        BLACK,
    )
    figures.walker(canvas, 1.1, 0.0, -0.45)


def ramp(canvas: Canvas) -> None:
    """A wheelchair on a ramp."""
    canvas.fill("-98 92 98 20 98 92", BLACK)
    wheelchair(canvas.placed(0.66, 0.0, -0.07, mirror=True, turn=-20))


def children_at_play(canvas: Canvas) -> None:
    """A man and a child with a ball, a house and a car: residential area."""
    canvas.fill("28 -8 28 -58 62 -92 96 -58 96 -8", BLACK)
    canvas.fill("52 -8 52 -38 74 -38 74 -8", WHITE)
    figures.walker(canvas, 1.05, -0.62, -0.3, running=True)
    figures.walker(canvas, 0.66, 0.06, -0.2, running=True)
    canvas.disc(-0.18, 0.2, 0.08, BLACK)
    car_side(canvas.placed(0.36, 0.6, 0.4))
    canvas.fill("-98 84 98 84 98 92 -98 92", BLACK)


def cow(canvas: Canvas) -> None:
    """A cow."""
    canvas.fill(
        "-98 -8 Q -98 -22 -88 -26 L -74 -44 -58 -46 Q -40 -44 -20 -40 L 60 -42 Q 84 -42 88 -24 L 88 8 82 40 86 82 70 "
        "82 66 42 56 18 Q 20 28 -24 22 L -38 20 -38 46 -34 82 -50 82 -56 44 -62 8 Q -68 -2 -74 -6 L -88 4 Q -98 4 -98 "
        "-8",
        BLACK,
    )
    canvas.stroke("-70 -42 -84 -58", 0.06, BLACK, caps=True)
    canvas.stroke("-60 -42 -58 -62", 0.06, BLACK, caps=True)
    canvas.stroke("86 -30 98 -10 94 30", 0.055, BLACK, caps=True)
    canvas.stroke("-24 18 -20 80", 0.13, BLACK)
    canvas.stroke("54 18 52 80", 0.13, BLACK)
    canvas.fill("26 18 52 18 46 36 32 36", BLACK)


def horse(canvas: Canvas) -> None:
    """A trotting horse."""
    canvas.fill(
        "-98 -36 Q -96 -48 -84 -52 L -68 -70 -62 -84 -56 -72 Q -36 -62 -28 -34 L -20 -18 Q 20 -12 60 -22 84 -22 88 2 L "
        "86 14 72 40 84 60 78 92 66 92 70 64 52 42 48 22 Q 16 36 -18 26 L -26 48 -22 70 -34 92 -46 90 -36 68 -44 40 "
        "-50 6 -56 -34 -70 -34 -84 -24 Q -96 -26 -98 -36",
        BLACK,
    )
    canvas.stroke("-34 22 -62 36 -64 60", 0.12, BLACK, caps=True)
    canvas.stroke("60 24 48 62 32 78", 0.12, BLACK, caps=True)
    canvas.stroke("84 -12 98 8 96 44", 0.1, BLACK, caps=True)


def rider(canvas: Canvas) -> None:
    """A rider on a horse."""
    horse(canvas.placed(0.82, 0.04, 0.24))
    canvas.disc(0.06, -0.8, 0.13, BLACK)
    canvas.fill("-4 -66 18 -66 26 -40 26 4 -2 6 0 -36", BLACK)
    canvas.stroke("4 -56 -10 -30 -32 -22", 0.09, BLACK, caps=True)
    canvas.placed(1, colours={BLACK: WHITE}).stroke("12 2 -10 20 -4 60", 0.2, BLACK, caps=True)
    canvas.stroke("12 2 -10 20 -4 58 -18 62", 0.11, BLACK, caps=True)


def horse_cart(canvas: Canvas) -> None:
    """A cart drawn by a horse."""
    horse(canvas.placed(0.6, -0.4, 0.04))
    canvas.stroke("-50 8 60 18", 0.06, BLACK)
    canvas.fill("24 -6 98 -6 94 22 28 22", BLACK)
    cart_wheel(canvas, 0.6, 0.34, 0.27)


def handcart(canvas: Canvas) -> None:
    """A man who pushes a cart."""
    figures.walker(canvas, 1.2, 0.62, 0.0)
    canvas.stroke("46 -2 4 4", 0.07, BLACK, caps=True)
    canvas.fill("-98 -16 10 -16 2 14 -88 14", BLACK)
    cart_wheel(canvas, -0.42, 0.3, 0.36)


def frog(canvas: Canvas) -> None:
    """A frog from above."""
    canvas.fill("-26 -60 Q 0 -92 26 -60 44 -30 40 10 30 56 0 64 -30 56 -40 10 -44 -30 -26 -60", BLACK)
    for side in canvas.halves():
        side.disc(0.22, -0.68, 0.12, BLACK)
        side.stroke("30 -24 66 -44 72 -78", 0.14, BLACK, caps=True)
        side.stroke("72 -78 58 -90", 0.07, BLACK, caps=True)
        side.stroke("72 -78 86 -92", 0.07, BLACK, caps=True)
        side.stroke("26 38 78 24 60 82", 0.18, BLACK, caps=True)
        side.stroke("60 82 84 92", 0.08, BLACK, caps=True)
        side.stroke("60 82 66 98", 0.08, BLACK, caps=True)
