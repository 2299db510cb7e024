"""Converts rotated boxes to upright ones."""

from __future__ import annotations

import math

from tsr_engine.exchange.box_rules import Edges
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.reading import rule_error


def bounding_box(edges: Edges, degrees: float, validator: ImportValidator, file: str, line: int | str | None) -> Edges:
    """The upright box around a rotated one, which is reported; a box without rotation or area is returned unchanged.

    Args:
        edges: of the box before its rotation, px.
        degrees: rotation about the centre, clockwise.
        validator: takes the reports.
        file: for messages.
        line: place in the file.

    Raises:
        ImportFormatError: the rotation is not finite.
    """
    if not math.isfinite(degrees):
        raise rule_error(file, line, f"rotation must be a finite number of degrees. Got {degrees}.")
    x1, y1, x2, y2 = edges
    if not degrees % 360 or not (x1 < x2 and y1 < y2):
        return edges
    cos, sin = abs(math.cos(math.radians(degrees))), abs(math.sin(math.radians(degrees)))
    half_w = ((x2 - x1) * cos + (y2 - y1) * sin) / 2
    half_h = ((x2 - x1) * sin + (y2 - y1) * cos) / 2
    cx, cy = (x1 + x2) / 2, (y1 + y2) / 2
    validator.count("Rotated boxes were replaced by the upright boxes around them", file, line)
    return cx - half_w, cy - half_h, cx + half_w, cy + half_h
