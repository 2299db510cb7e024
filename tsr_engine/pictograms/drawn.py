"""Looks up drawings by name: `gtsrb/14`, `vienna/no-parking`."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from tsr_engine.pictograms import gtsrb
from tsr_engine.pictograms.canvas import Canvas
from tsr_engine.pictograms.vienna import DRAWINGS

__all__ = ["draw", "names", "svg"]


@cache
def names() -> tuple[str, ...]:
    """Names of all drawings."""
    return (*(f"gtsrb/{number}" for number in range(gtsrb.N_CLASSES)), *(f"vienna/{key}" for key in DRAWINGS))


def draw(name: str, size: int) -> NDArray[np.uint8]:
    """A drawing as a picture.

    Args:
        name: one of `names()`.
        size: side of the picture, px.

    Returns:
        (size, size, 4) picture, BGRA, sRGB, straight alpha, transparent around the sign.

    Raises:
        KeyError: no drawing has that name.
        ValueError: the size is below 1.
    """
    return _drawing(name).picture(size)


def svg(name: str) -> str:
    """A drawing as an SVG document, transparent around the sign.

    Raises:
        KeyError: no drawing has that name.
    """
    return _drawing(name).svg()


def _drawing(name: str) -> Canvas:
    if name not in names():
        raise KeyError(name)
    family, key = name.split("/", 1)
    return gtsrb.drawing(int(key)) if family == "gtsrb" else DRAWINGS[key]()
