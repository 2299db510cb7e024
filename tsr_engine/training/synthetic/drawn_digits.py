"""Draws digits as strokes with random proportions, for limits in type faces without a font file here.

Road authorities use their own digits: narrow or wide, round or squared like a rounded rectangle, with long or short
arms. Strokes along superellipses ``|x / rx|^n + |y / ry|^n = 1`` give all of these from a few numbers: n = 2
is a round face, n = 5 is nearly rectangular.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["STROKED", "stroked_digits"]

_HEIGHT: Final = 120.0
"""Height of the digits, px."""
_STEPS: Final = 24
"""Number of points on an arc."""
_Line = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Face:
    """Proportions of a type face; lengths are shares of the digits' height.

    Attributes:
        width: width of a digit, between the middles of its strokes.
        power: n of the superellipses.
        waist: height of the middle of 3, 6 and 8, from the top.
        upper: width of the upper bowl of 3 and 8, as a share of the lower bowl's.
        hook: end of open arms, in degrees from the middle of their side towards the top or bottom.
        straight: whether the back of the 6 is straight instead of curved.
        flag: length of the 1's flag.
    """

    width: float
    power: float
    waist: float
    upper: float
    hook: float
    straight: bool
    flag: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> _Face:
        low, high = (0.38, 2.0, 0.44, 0.8, 12.0), (0.62, 5.0, 0.5, 1.0, 50.0)
        width, power, waist, upper, hook = rng.uniform(low, high).tolist()
        return cls(width, power, waist, upper, hook, bool(rng.random() < 0.2), float(rng.uniform(0.12, 0.28)))

    def arc(self, top: float, bottom: float, start: float, end: float, share: float = 1.0) -> _Line:
        """Points of a bowl between two heights; degrees clockwise from the right, 90 is the bottom."""
        angle = np.radians(np.linspace(start, end, _STEPS))
        c, s = np.cos(angle), np.sin(angle)
        x = np.sign(c) * np.abs(c) ** (2 / self.power) * share * self.width / 2
        y = np.sign(s) * np.abs(s) ** (2 / self.power) * (bottom - top) / 2
        return np.stack([x + self.width / 2, y + (top + bottom) / 2], axis=1)


def _zero(f: _Face) -> list[_Line]:
    return [f.arc(0.0, 1.0, 0.0, 360.0)]


def _one(f: _Face) -> list[_Line]:
    return [np.array([(0.0, f.flag * 0.8), (f.flag, 0.0), (f.flag, 1.0)])]


def _two(f: _Face) -> list[_Line]:
    bowl = f.arc(0.0, 2 * f.waist * 0.6, 180.0 + f.hook / 2, 385.0)
    return [np.concatenate([bowl, [(0.0, 1.0), (f.width, 1.0)]])]


def _three(f: _Face) -> list[_Line]:
    upper = f.arc(0.0, f.waist, 180.0 + f.hook, 450.0, f.upper)
    lower = f.arc(f.waist, 1.0, -90.0, 180.0 - f.hook)
    return [upper, np.concatenate([[(0.4 * f.width, f.waist)], lower])]


def _five(f: _Face) -> list[_Line]:
    lower = f.arc(f.waist * 0.85, 1.0, -140.0, 180.0 - max(f.hook, 20.0))
    corner = np.array([(0.92 * f.width, 0.0), (0.06 * f.width, 0.0), (0.0, f.waist * 1.1)])
    return [np.concatenate([corner, lower])]


def _six(f: _Face) -> list[_Line]:
    top = f.waist * 0.85
    bowl = f.arc(top, 1.0, 180.0, 540.0)
    middle = (top + 1.0) / 2
    if f.straight:
        return [np.concatenate([[(0.72 * f.width, 0.0)], bowl])]
    # An arm down to the bowl would make it an 8.
    back = f.arc(0.0, 1.0, -30.0 - 0.6 * f.hook, -180.0)
    return [np.concatenate([back[back[:, 1] <= middle], [(0.0, middle)]]), bowl]


def _seven(f: _Face) -> list[_Line]:
    return [np.array([(0.0, 0.0), (f.width, 0.0), (0.32 * f.width, 1.0)])]


def _eight(f: _Face) -> list[_Line]:
    return [f.arc(0.0, f.waist, 0.0, 360.0, f.upper), f.arc(f.waist, 1.0, 0.0, 360.0)]


_DIGITS: Final[dict[str, Callable[[_Face], list[_Line]]]] = {
    "0": _zero, "1": _one, "2": _two, "3": _three, "5": _five, "6": _six, "7": _seven, "8": _eight,
}  # fmt: skip
STROKED: Final = "".join(_DIGITS)
"""Digits that can be drawn: those of the limits of GTSRB."""


def stroked_digits(text: str, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Draw a number in a random face as a mask about 150 px high; the ink does not touch the mask's edge.

    Args:
        text: digits of ``STROKED``.
        rng: source of the face.

    Raises:
        ValueError: the text has another character.
    """
    if not text or set(text) - set(STROKED):
        raise ValueError(f"text must be made of {STROKED}. Got {text!r} instead.")
    face = _Face.draw(rng)
    weight = max(6, round(_HEIGHT * rng.uniform(0.09, 0.2)))
    gap = _HEIGHT * rng.uniform(0.08, 0.2) + weight
    left, lines = 20.0 + weight, []
    for digit in text:
        strokes = [line * _HEIGHT + (left, 15.0 + weight) for line in _DIGITS[digit](face)]
        lines += strokes
        left = max(float(line[:, 0].max()) for line in strokes) + gap
    mask = np.zeros((round(_HEIGHT) + 2 * weight + 30, round(left) + weight + 20), np.uint8)
    points = [np.round(line * 16).astype(np.int32) for line in lines]
    cv2.polylines(mask, points, isClosed=False, color=255, thickness=weight, lineType=cv2.LINE_AA, shift=4)
    return mask
