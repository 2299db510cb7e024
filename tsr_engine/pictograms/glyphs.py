"""Digits and capitals of a road-sign grotesque, as centre lines drawn with a pen of constant width."""

from __future__ import annotations

import numpy as np

from tsr_engine.pictograms.canvas import Canvas, Colour, arc
from tsr_engine.pictograms.letters import LETTERS
from tsr_engine.pictograms.paths import Points, path

PEN = 0.15
"""Pen width as a share of a digit's height."""

_WIDTH = 0.56
_A = PEN / 2
_R = _WIDTH / 2 - _A
_CX = _WIDTH / 2
_GAP = 0.13


def _line(*points: tuple[float, float]) -> Points:
    return np.array(points, np.float64)


def _ring(cy: float, rx: float, ry: float) -> Points:
    return arc(_CX, cy, rx, ry, 0, 360, 48)


def _strokes(symbol: str) -> list[Points]:
    """Centre lines of a symbol in a box `_WIDTH` wide and 1 high (y down)."""
    top, bottom, left, right = _A, 1 - _A, _A, _WIDTH - _A
    zero = np.concatenate([arc(_CX, top + _R, _R, _R, 180, 360), arc(_CX, bottom - _R, _R, _R, 0, 180)])
    five, nine = _line((right + 0.03, top), (left + 0.05, top), (left + 0.03, 0.45)), _line((0.10, bottom))
    bowl = np.concatenate([arc(0.27, 0.31, _R + 0.01, 0.235, -90, 90), _line((left, 0.545))])
    table: dict[str, list[Points]] = {
        "0": [np.concatenate([zero, zero[:1]])],
        "1": [_line((0.08, 0.30), (0.36, top + 0.02)), _line((0.36, 0.0), (0.36, 1.0))],
        "2": [np.concatenate([arc(_CX, top + _R, _R, _R, 180, 385), _line((left + 0.03, bottom), (_WIDTH, bottom))])],
        "3": [np.concatenate([arc(_CX, 0.27, 0.185, 0.195, 205, 450), arc(_CX, 0.695, _R, 0.23, 270, 515)])],
        "4": [_line((0.36, 0.0), (0.06, 0.70), (_WIDTH + 0.02, 0.70)), _line((0.40, 0.40), (0.40, 1.0))],
        "5": [np.concatenate([five, arc(_CX - 0.01, 0.665, _R, 0.26, 235, 515)])],
        "6": [_ring(0.69, _R, 0.235), np.concatenate([arc(0.47, 0.66, 0.395, 0.60, 180, 262), _line((0.46, top))])],
        "9": [_ring(0.31, _R, 0.235), np.concatenate([arc(_WIDTH - 0.47, 0.34, 0.395, 0.60, 0, 82), nine])],
        "7": [_line((0.0, top), (right, top), (0.20, 1.0))],
        "8": [_ring(0.27, 0.175, 0.195), _ring(0.71, _R, 0.215)],
        "S": [np.concatenate([arc(_CX, 0.28, _R, 0.205, 335, 90), arc(_CX, 0.705, _R, 0.22, -90, 155)])],
        "T": [_line((0.0, top), (_WIDTH, top)), _line((_CX, top), (_CX, 1.0))],
        "O": [np.concatenate([zero, zero[:1]])],
        "P": [_line((left, 0.0), (left, 1.0)), np.concatenate([_line((left, top), (0.27, top)), bowl])],
    }
    return table[symbol] if symbol in table else [path(line) for line in LETTERS[symbol][1]]


def _advance(symbol: str) -> float:
    """Width of a symbol, as a multiple of a digit's height."""
    if symbol in LETTERS:
        return LETTERS[symbol][0] / 100
    return 0.44 if symbol == "1" else _WIDTH


def text_width(text: str) -> float:
    """Width of a text, as a multiple of a digit's height."""
    return sum(_advance(symbol) for symbol in text) + _GAP * (len(text) - 1)


def write(canvas: Canvas, text: str, height: float, cx: float, cy: float, colour: Colour, squeeze: float = 1.0) -> None:
    """Write a text centred on a point.

    Args:
        canvas: Where to draw.
        text: Digits, capitals, some small letters and signs.
        height: Height of the symbols in units of the canvas.
        cx: Centre, right.
        cy: Centre, down.
        colour: Ink (r, g, b), sRGB.
        squeeze: Horizontal scale of the symbols.
    """
    x = -text_width(text) / 2
    for symbol in text:
        for points in _strokes(symbol):
            placed = np.stack([cx + (points[:, 0] + x) * height * squeeze, cy + (points[:, 1] - 0.5) * height], axis=1)
            canvas.stroke(placed, PEN * height * (0.5 + squeeze / 2), colour)
        x += _advance(symbol) + _GAP
