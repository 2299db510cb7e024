"""Parts of vehicles: bodies between cross-sections, panels, wheels, lamps."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from sample_videos.colour import Linear, lin
from sample_videos.meshes import Face, outward

Array = NDArray[np.float64]
GLASS, RUBBER, TRIM = lin(26, 32, 38), lin(20, 20, 21), lin(34, 34, 36)
_WHEEL = ((1.12, lin(12, 12, 13), 0.0), (1.0, RUBBER, 0.012), (0.62, lin(120, 122, 126), 0.02), (0.2, TRIM, 0.03))
"""Discs of a wheel: radius as a share of the tyre's, colour, and how far it stands out, metres."""


def loft(stations: Array, colour: Linear, gloss: float, power: float) -> list[Face]:
    """Surface over cross-sections.

    Args:
        stations: (n, 5): z, bottom, top, half width at the bottom, half width at the top.
        colour: Albedo.
        gloss: Mirror share.
        power: Roundness of the shoulders, 0 to 0.5.
    """
    rings = []
    for z, low, high, wide, narrow in stations:
        tall = high - low
        shoulder = wide * 0.5 + narrow * 0.5, high - power * tall
        half = [(wide * 0.93, low), (wide, low + 0.25 * tall), shoulder, (narrow * 0.86, high)]
        ring = [(-x, y, z) for x, y in half] + [(x, y, z) for x, y in reversed(half)]
        rings.append(np.array(ring))
    middle = np.concatenate(rings).mean(0)
    faces: list[Face] = []
    for a, b in itertools.pairwise(rings):
        inner = (a.mean(0) + b.mean(0)) / 2
        faces.extend(Face(outward(np.stack([a[k], a[k + 1], b[k + 1], b[k]]), inner), colour, gloss) for k in range(7))
    faces.append(Face(outward(rings[0], middle), colour, gloss))
    faces.append(Face(outward(rings[-1], middle), colour, gloss))
    return faces


def panel(points: list[tuple[float, float, float]], middle: Array, colour: Linear, gloss: float = 0.0) -> Face:
    """A flat face that faces away from ``middle``."""
    return Face(outward(np.array(points, np.float64), middle), colour, gloss)


def trapezium(
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    middle: Array,
    colour: Linear,
    gloss: float = 0.0,
) -> Face:
    """A panel across the vehicle; ``low`` and ``high`` are half width, height and position ahead of two edges."""
    (w0, y0, z0), (w1, y1, z1) = low, high
    return panel([(-w0, y0, z0), (w0, y0, z0), (w1, y1, z1), (-w1, y1, z1)], middle, colour, gloss)


def flank(
    side: int,
    low: tuple[float, float, float, float],
    high: tuple[float, float, float, float],
    middle: Array,
    colour: Linear,
    gloss: float,
) -> Face:
    """A panel along one side (-1 or 1).

    Args:
        side: -1 left, 1 right.
        low: half width, height, rear end and front end of the lower edge.
        high: the same of the upper edge.
        middle: a point inside the vehicle.
        colour: albedo.
        gloss: mirror share.
    """
    (x0, y0, rear0, front0), (x1, y1, rear1, front1) = low, high
    x0, x1 = side * x0, side * x1
    return panel([(x0, y0, rear0), (x0, y0, front0), (x1, y1, front1), (x1, y1, rear1)], middle, colour, gloss)


def number_plate(y: float, z: float, middle: Array) -> Face:
    """A number plate whose lower edge lies at a height."""
    return trapezium((0.26, y, z), (0.26, y + 0.11, z), middle, lin(222, 224, 220))


def wheels(length: float, width: float, radius: float, axles: tuple[float, ...]) -> list[Face]:
    """Wheels on both sides; ``axles`` are their positions as shares of the length."""
    faces = []
    angle = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    for z in axles:
        for side in (-1.0, 1.0):
            middle = np.array([0.0, radius, z * length])
            for r, colour, push in _WHEEL:
                rim = np.full(14, side * (width / 2 + push))
                points = np.stack(
                    [rim, radius + r * radius * np.sin(angle), z * length + r * radius * np.cos(angle)], axis=1
                )
                faces.append(Face(outward(points, middle), colour, 0.25 if r == 0.62 else 0.0))
        tread = np.array([[-1, 0], [1, 0], [1, radius * 1.1], [-1, radius * 1.1]])
        for side in (-1.0, 1.0):
            at = side * (width / 2 - 0.13)
            for end in (-1, 1):
                points = np.stack(
                    [at + tread[:, 0] * 0.12, tread[:, 1], np.full(4, z * length + end * radius * 0.8)], axis=1
                )
                faces.append(Face(outward(points, np.array([at, radius, z * length])), RUBBER))
    return faces


def lamps(half: float, y: float, z: float, front: bool, lit: bool, size: tuple[float, float]) -> list[Face]:
    """The two lamps of one end, ``size`` wide and tall, at the edge of a body that is 2 ``half`` wide."""
    end = 1 if front else -1
    inside = np.array([0.0, y, z - end])
    colour = lin(225, 228, 230) if front else lin(170, 14, 18)
    gloss = 0.35
    if lit and not front:
        colour, gloss = lin(255, 40, 40), 0.2
    out = []
    for side in (-1, 1):
        x0, x1 = side * (half - size[0]), side * half
        points = np.array([(x0, y, z), (x1, y, z), (x1, y + size[1], z), (x0, y + size[1], z)])
        out.append(Face(outward(points, inside), colour, gloss, 9.0 if front and lit else 0.0))
    return out
