"""Cars, vans and lorries: flat faces in a frame of right, up, forward, the origin on the ground."""

from __future__ import annotations

import numpy as np

from sample_videos.colour import lin
from sample_videos.meshes import Face, box
from sample_videos.vehicle_parts import GLASS, TRIM, flank, lamps, loft, number_plate, panel, trapezium, wheels

PAINTS: tuple[tuple[int, int, int], ...] = (
    (150, 18, 24), (28, 58, 120), (196, 198, 200), (60, 62, 66), (226, 226, 224),
    (24, 24, 28), (18, 92, 78), (132, 138, 146), (190, 150, 30),
)  # fmt: skip
"""Paints of cars, sRGB; red, blue and yellow may trigger a detector."""


def car(rng: np.random.Generator, *, lit: bool, paint: tuple[int, int, int] | None = None) -> list[Face]:
    """A passenger car, an estate or a saloon; `lit` switches its lamps on."""
    colour = lin(*(paint or PAINTS[int(rng.integers(len(PAINTS)))]))
    estate = bool(rng.random() < 0.5)
    length, half, high = rng.uniform(4.1, 4.6), rng.uniform(0.86, 0.92), rng.uniform(1.43, 1.5)
    a, b = -length / 2, length / 2
    belt = 0.92
    hull = np.array(
        [
            [a, 0.34, 0.72, half * 0.86, half * 0.84],
            [a + 0.12, 0.27, belt + 0.02, half * 0.97, half * 0.93],
            [a + 0.9, 0.24, belt + 0.03, half, half * 0.95],
            [0.0, 0.22, belt, half, half * 0.95],
            [b - 1.25, 0.22, belt - 0.03, half, half * 0.94],
            [b - 0.35, 0.24, 0.80, half * 0.97, half * 0.88],
            [b - 0.05, 0.27, 0.66, half * 0.86, half * 0.78],
            [b, 0.32, 0.56, half * 0.78, half * 0.74],
        ]
    )
    faces = loft(hull, colour, 0.5, 0.22)
    r0, r1 = (a + 0.45, b - 2.15) if estate else (a + 1.15, b - 2.25)
    c0, c1 = (a + 0.12, b - 1.15) if estate else (a + 0.55, b - 1.2)
    roof, base = half * 0.70, half * 0.90
    middle = np.array([0.0, 1.1, 0.0])
    y = belt - 0.02
    ridge = [(-roof, high, r0), (roof, high, r0), (roof, high + 0.02, 0.0), (roof, high, r1), (-roof, high, r1)]
    faces += [
        panel([*ridge, (-roof, high + 0.02, 0)], middle, colour, 0.5),
        trapezium((base, y, c0), (roof, high, r0), middle, colour, 0.4),
        trapezium((base * 0.86, y + 0.06, c0 - 0.01), (roof * 0.90, high - 0.07, r0 - 0.02), middle, GLASS, 0.8),
        trapezium((base, y, c1), (roof, high, r1), middle, colour, 0.4),
        trapezium((base * 0.93, y + 0.03, c1 + 0.01), (roof * 0.93, high - 0.05, r1 + 0.02), middle, GLASS, 0.8),
    ]
    for side in (-1, 1):
        faces.append(flank(side, (base, y, c0, c1), (roof, high, r0, r1), middle, colour, 0.4))
        for z0, z1, t0, t1 in ((0.05, 0.48, 0.06, 0.46), (0.52, 0.93, 0.50, 0.95)):
            low = (base * 1.004, y + 0.03, c0 + (c1 - c0) * z0, c0 + (c1 - c0) * z1)
            top = (roof * 1.02, high - 0.06, r0 + (r1 - r0) * t0, r0 + (r1 - r0) * t1)
            faces.append(flank(side, low, top, middle, GLASS, 0.7))
        at = side * (half + 0.02)
        faces += box((at - 0.08, at + 0.08), (belt, belt + 0.13), (b - 1.55, b - 1.45), colour)
    back, nose = a - 0.012, b + 0.012
    faces += [
        trapezium((half * 0.8, 0.33, back), (half * 0.8, 0.46, back), np.zeros(3), TRIM),
        number_plate(0.52, back, np.zeros(3)),
        *lamps(half * 0.93, 0.70, a + 0.04, False, lit, (0.26, 0.17)),
        trapezium((half * 0.6, 0.33, nose), (half * 0.62, 0.50, nose), np.zeros(3), TRIM),
        number_plate(0.40, nose + 0.01, np.zeros(3)),
        *lamps(half * 0.86, 0.56, b - 0.02, True, lit, (0.3, 0.13)),
    ]
    return faces + wheels(length, 2 * half, 0.31, (-0.29, 0.31))


def van(rng: np.random.Generator, *, lit: bool) -> list[Face]:
    """A delivery van."""
    colour = lin(*((228, 228, 226), (214, 190, 60), (206, 208, 210), (44, 70, 118))[int(rng.integers(4))])
    a, b, half, high = -2.7, 2.7, 0.98, 2.45
    hull = np.array(
        [
            [a, 0.42, high - 0.12, half * 0.97, half * 0.88],
            [a + 0.1, 0.36, high, half, half * 0.92],
            [b - 1.7, 0.34, high, half, half * 0.92],
            [b - 1.45, 0.34, high - 0.18, half, half * 0.9],
            [b - 0.75, 0.34, 1.28, half, half * 0.92],
            [b - 0.1, 0.36, 1.02, half * 0.95, half * 0.86],
            [b, 0.4, 0.72, half * 0.85, half * 0.8],
        ]
    )
    faces = loft(hull, colour, 0.3, 0.10)
    middle = np.array([0.0, 1.2, 0.0])
    back = a - 0.012
    for side in (-1, 1):
        window = [(0.06, 1.45), (0.76, 1.45), (0.74, 2.05), (0.06, 2.05)]
        faces.append(panel([(side * x, y, back) for x, y in window], middle, GLASS, 0.7))
        low, top = (half * 1.004, 1.3, b - 1.75, b - 0.95), (half * 0.96, 2.0, b - 1.75, b - 1.4)
        faces.append(flank(side, low, top, middle, GLASS, 0.7))
    faces += [
        trapezium((half * 0.84, 1.36, b - 0.76), (half * 0.80, high - 0.26, b - 1.40), middle, GLASS, 0.8),
        trapezium((0.02, 0.5, back), (0.02, 2.25, back), middle, TRIM),
        trapezium((half * 0.9, 0.42, back), (half * 0.9, 0.6, back), middle, TRIM),
        number_plate(0.72, back, middle),
        trapezium((0.6, 0.5, b + 0.01), (0.6, 0.72, b + 0.01), middle, TRIM),
        *lamps(half * 0.94, 0.95, a - 0.015, False, lit, (0.14, 0.42)),
        *lamps(half * 0.84, 0.78, b - 0.02, True, lit, (0.3, 0.2)),
    ]
    return faces + wheels(b - a, 2 * half, 0.34, (-0.30, 0.33))


def lorry(rng: np.random.Generator, *, lit: bool) -> list[Face]:
    """A lorry with a box body."""
    cargo = lin(*((40, 84, 148), (206, 206, 200), (166, 36, 34), (58, 110, 74))[int(rng.integers(4))])
    cab = lin(*((220, 220, 218), (160, 24, 28), (30, 60, 120))[int(rng.integers(3))])
    faces = box((-1.25, 1.25), (0.95, 3.6), (-4.4, 2.2), cargo, 0.06)
    faces += box((-1.15, 1.15), (0.55, 0.95), (-4.3, 2.2), TRIM)
    faces += box((-1.2, 1.2), (0.5, 2.95), (2.35, 4.4), cab, 0.3)
    middle = np.array([0.0, 1.8, 3.3])
    faces.append(trapezium((1.08, 1.75, 4.42), (1.08, 2.7, 4.42), middle, GLASS, 0.8))
    faces += [flank(side, (1.21, 1.7, 3.2, 4.2), (1.21, 2.5, 3.2, 4.1), middle, GLASS, 0.7) for side in (-1, 1)]
    faces.append(trapezium((1.15, 0.6, 4.42), (1.15, 0.95, 4.42), middle, TRIM))
    faces.append(trapezium((0.9, 1.05, 4.42), (0.9, 1.5, 4.42), middle, TRIM))
    faces += box((-1.15, 1.15), (0.45, 0.6), (-4.45, -4.35), lin(170, 24, 24))
    faces.append(trapezium((0.02, 1.0, -4.42), (0.02, 3.5, -4.42), np.array([0.0, 2.0, 0.0]), TRIM))
    faces += lamps(1.1, 0.68, -4.46, False, lit, (0.3, 0.14))
    faces += lamps(1.1, 0.70, 4.43, True, lit, (0.32, 0.18))
    return faces + wheels(8.8, 2.4, 0.48, (-0.36, -0.23, 0.38))
