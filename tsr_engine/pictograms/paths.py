"""Reads outlines from short texts that resemble SVG paths, in hundredths of the canvas's unit."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

_TOKEN = re.compile(r"[LQ]|-?\d+(?:\.\d+)?")
_STEPS = 10
"""Number of segments of a curve."""


def path(text: str) -> Points:
    """Points along a path.

    Args:
        text: pairs of numbers ``x y``; after ``Q``, each two pairs are a control point and an end point of a quadratic
            curve; after ``L``, pairs are corners again. All are absolute, 100 is the canvas's unit.

    Returns:
        (n, 2) points.

    Raises:
        ValueError: a number is missing.
    """
    points: list[tuple[float, float]] = []
    kind, numbers = "L", list[float]()
    for word in _TOKEN.findall(text):
        if word in "LQ":
            if numbers:
                raise ValueError(f"path: {len(numbers)} numbers too many before {word} in {text!r}")
            kind = word
            continue
        numbers.append(float(word) / 100)
        if kind == "L" and len(numbers) == 2:
            points.append((numbers[0], numbers[1]))
            numbers.clear()
        elif kind == "Q" and len(numbers) == 4:
            (x0, y0), (x1, y1, x2, y2) = points[-1], numbers
            for k in range(1, _STEPS + 1):
                t = k / _STEPS
                a, b, c = (1 - t) ** 2, 2 * t * (1 - t), t * t
                points.append((a * x0 + b * x1 + c * x2, a * y0 + b * y1 + c * y2))
            numbers.clear()
    if numbers:
        raise ValueError(f"path: {len(numbers)} numbers too many at the end of {text!r}")
    return np.array(points, np.float64)
