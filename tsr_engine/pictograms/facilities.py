"""Symbols of facilities and services, in black on white, each within the unit square."""

from __future__ import annotations

import numpy as np

from tsr_engine.pictograms.canvas import Canvas, arc
from tsr_engine.pictograms.glyphs import write
from tsr_engine.pictograms.palette import BLACK, RED, WHITE


def red_cross(canvas: Canvas) -> None:
    """A red cross."""
    canvas.fill("-28 -84 28 -84 28 -28 84 -28 84 28 28 28 28 84 -28 84 -28 28 -84 28 -84 -28 -28 -28", RED)


def wrench(canvas: Canvas) -> None:
    """A spanner."""
    tool = canvas.placed(1, turn=45)
    tool.fill("-15 -50 15 -50 15 60 -15 60", BLACK)
    for y in (-0.68, 0.72):
        tool.disc(0, y, 0.31, BLACK)
    tool.fill("-13 -104 13 -104 13 -66 -13 -66", WHITE)
    tool.fill("-13 108 13 108 13 72 -13 72", WHITE)


def handset(canvas: Canvas) -> None:
    """The handset of a telephone."""
    phone = canvas.placed(1, turn=-45)
    phone.fill(
        "-84 -22 Q -84 -56 -40 -56 L 40 -56 Q 84 -56 84 -22 L 84 18 44 18 44 -14 Q 20 -22 0 -22 -20 -22 -44 -14 L -44 "
        "18 -84 18",
        BLACK,
    )


def fuel_pump(canvas: Canvas) -> None:
    """A pump of a filling station."""
    canvas.fill("-70 92 -70 -76 Q -70 -92 -54 -92 L 18 -92 Q 34 -92 34 -76 L 34 92", BLACK)
    canvas.fill("-52 -24 -52 -72 16 -72 16 -24", WHITE)
    canvas.stroke("34 8 Q 56 8 56 30 L 56 52 Q 56 72 68 72 80 72 80 52 L 80 -36 52 -66", 0.1, BLACK, caps=True)
    canvas.fill("62 -40 86 -40 86 -8 62 -8", BLACK)


def charging(canvas: Canvas) -> None:
    """A pump with a flash: electric charging."""
    canvas.fill("-70 92 -70 -76 Q -70 -92 -54 -92 L 18 -92 Q 34 -92 34 -76 L 34 92", BLACK)
    canvas.fill("0 -74 -50 6 -22 6 -38 64 16 -20 -12 -20", WHITE)
    canvas.stroke("34 40 Q 60 40 60 20 L 60 -20", 0.09, BLACK)
    canvas.fill("44 -52 76 -52 76 -26 Q 76 -12 60 -12 44 -12 44 -26", BLACK)
    for x in (52, 68):
        canvas.stroke(f"{x} -48 {x} -74", 0.07, BLACK)


def bed(canvas: Canvas) -> None:
    """A bed with a sleeper."""
    canvas.fill("-98 60 -98 -50 -82 -50 -82 18 98 18 98 60 82 60 82 42 -82 42 -82 60", BLACK)
    canvas.disc(-0.54, -0.1, 0.19, BLACK)
    canvas.fill("-30 10 -30 -26 Q 98 -26 98 10", BLACK)


def fork_and_knife(canvas: Canvas) -> None:
    """A fork and a knife."""
    canvas.fill("-42 -6 -42 92 -22 92 -22 -6", BLACK)
    canvas.fill(
        "-64 -92 -64 -28 Q -64 4 -32 4 0 4 0 -28 L 0 -92 -12 -92 -12 -34 -24 -34 -24 -92 -40 -92 -40 -34 -52 -34 -52 "
        "-92",
        BLACK,
    )
    canvas.fill("30 92 30 -92 Q 66 -74 66 -8 L 50 6 50 92", BLACK)


def cup(canvas: Canvas) -> None:
    """A steaming cup."""
    canvas.fill("-78 -24 46 -24 Q 46 46 8 56 L -40 56 Q -78 46 -78 -24", BLACK)
    canvas.stroke(arc(0.46, 0.06, 0.26, 0.24, -90, 90, 14), 0.11, BLACK)
    canvas.fill("-92 66 66 66 54 82 -80 82", BLACK)
    for x in (-46, -16, 14):
        canvas.stroke(f"{x} -38 Q {x - 14} -54 {x} -66 {x + 14} -78 {x} -92", 0.07, BLACK)


def picnic(canvas: Canvas) -> None:
    """A table with benches below a fir."""
    canvas.fill("44 -96 96 -10 70 -10 98 40 54 40 54 84 34 84 34 40 -10 40 18 -10 -8 -10", BLACK)
    canvas.placed(1, colours={BLACK: WHITE}).fill("-98 6 46 6 46 92 -98 92", BLACK)
    canvas.fill("-84 18 28 18 28 32 -84 32", BLACK)
    canvas.fill("-98 50 42 50 42 62 -98 62", BLACK)
    canvas.stroke("-54 30 -80 88", 0.11, BLACK)
    canvas.stroke("-2 30 24 88", 0.11, BLACK)


def tent(canvas: Canvas) -> None:
    """A tent."""
    canvas.fill("-6 -84 6 -84 98 74 -98 74 -6 -84", BLACK)
    canvas.fill("0 -40 0 -40 34 74 -34 74", WHITE)
    canvas.stroke("-14 -92 6 -62", 0.07, BLACK)
    canvas.stroke("14 -92 -6 -62", 0.07, BLACK)


def house_and_tree(canvas: Canvas) -> None:
    """A house beside a fir: youth hostel."""
    canvas.fill("-98 84 -98 -12 -46 -66 6 -12 6 84", BLACK)
    canvas.fill("-60 84 -60 22 -32 22 -32 84", WHITE)
    canvas.fill("52 -92 98 28 62 28 62 84 42 84 42 28 14 28", BLACK)


def information(canvas: Canvas) -> None:
    """The letter i."""
    canvas.disc(0, -0.68, 0.2, BLACK)
    canvas.fill("-38 -34 18 -34 18 66 42 66 42 90 -42 90 -42 66 -18 66 -18 -10 -38 -10", BLACK)


def sos(canvas: Canvas) -> None:
    """A handset above the letters SOS."""
    write(canvas, "SOS", 0.62, 0, 0.58, BLACK)
    handset(canvas.placed(0.66, 0, -0.36))


def extinguisher(canvas: Canvas) -> None:
    """A fire extinguisher."""
    canvas.fill("-40 92 -40 -24 Q -40 -52 -8 -56 L -8 -74 14 -74 14 -56 Q 44 -52 44 -24 L 44 92", RED)
    canvas.stroke("-14 -80 34 -92", 0.11, RED, caps=True)
    canvas.stroke("-10 -76 Q -66 -70 -66 -10 L -66 20", 0.11, RED)
    canvas.fill("-80 14 -52 14 -56 50 -76 50", RED)


def camera(canvas: Canvas) -> None:
    """A camera: speed control."""
    canvas.fill(
        "-98 66 -98 -34 Q -98 -48 -84 -48 L -48 -48 -34 -72 34 -72 48 -48 84 -48 Q 98 -48 98 -34 L 98 66", BLACK
    )
    canvas.disc(0, 0.08, 0.42, WHITE)
    canvas.disc(0, 0.08, 0.28, BLACK)
    canvas.fill("62 -34 84 -34 84 -20 62 -20", WHITE)


def horn(canvas: Canvas) -> None:
    """A horn with its rubber ball."""
    canvas.fill("-98 -46 Q -78 -14 -20 -10 L 40 -10 40 10 -20 10 Q -78 14 -98 46", BLACK)
    canvas.stroke(arc(0.18, 0.22, 0.22, 0.22, 180, -90, 30), 0.1, BLACK)
    canvas.fill(arc(0.68, 0, 0.3, 0.24, 0, 360, 40), BLACK)


def parking_disc(canvas: Canvas) -> None:
    """A disc clock whose hands show a time: parking disc."""
    canvas.fill("-80 92 -80 -92 80 -92 80 92", BLACK)
    canvas.fill("-66 78 -66 -78 66 -78 66 78", WHITE)
    canvas.stroke(arc(0, 0.2, 0.46, 0.46, 180, 360, 30), 0.1, BLACK)
    for degrees in (200, 235, 270, 305, 340):
        x, y = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        canvas.stroke(np.array([(0.28 * x, 0.2 + 0.28 * y), (0.46 * x, 0.2 + 0.46 * y)]), 0.07, BLACK)
    canvas.fill("0 20 -14 52 14 52", BLACK)
