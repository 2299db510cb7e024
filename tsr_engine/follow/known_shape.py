"""The offline detector's box at a place, adjusted to the way that the person draws boxes.

The detector's later stages know the shapes of signs. They are used if they accept the anchor as a sign and their box is
close to the person's. The remaining difference between the boxes is kept as the person's way of drawing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from tsr_engine.follow.pixels import PicturePixels
from tsr_engine.follow.template import size_of
from tsr_engine.geometry.boxes import iou_each, to_cxcywh, to_xyxy
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray, Picture

__all__ = ["KnownShape", "Seen", "WindowScorer", "know"]

WindowScorer = Callable[[PixelSource, FloatArray], ScoredBox | None]

_SURE_ANCHOR: Final = 0.0
"""Log-odds from which an anchor counts as a sign."""
_SAME: Final = 0.6
"""IoU with the person's box from which the detector's box shows the same object."""
_SURE: Final = -1.0
"""Log-odds from which a box of the detector is a measurement."""
_FAR: Final = 0.35
"""Largest distance of such a box, as a share of the size, and largest change of size, natural logarithm."""
_ERROR: Final = 0.05
"""Error of the size of a clear detection, natural logarithm."""
_CLEAR: Final = 6.0
"""Log-odds of a clear detection; each unit below adds ``_ERROR_GROWTH`` of the error."""
_ERROR_GROWTH: Final = 0.3
_DRAWN_PX: Final = 0.3
"""Error of the person's edges, px; on a small anchor it hides the person's way of drawing."""


@dataclass(frozen=True, slots=True)
class Seen:
    """The detector's result at a place.

    Attributes:
        score: log-odds of being a sign.
        box: shape (4,), px, as the person would draw it; None: too uncertain, or too far away.
        error: standard error of the natural logarithm of the box's size.
    """

    score: float
    box: FloatArray | None
    error: float


@dataclass(frozen=True, slots=True)
class KnownShape:
    """A sign that the detector knows.

    Attributes:
        window_scorer: the detector's later stages.
        shift: shape (2,), from the detector's centre to the person's, in sides of the detector's box.
        factor: shape (2,), the person's width and height, divided by the detector's.
        size: size of the anchor (root of its area), px.
    """

    window_scorer: WindowScorer
    shift: FloatArray
    factor: FloatArray
    size: float

    def at(self, picture: Picture, box: FloatArray) -> Seen | None:
        """The detector's result at a box (4,), px; None if the detector cannot score it."""
        own = to_cxcywh(box)
        own[2:] /= self.factor
        own[:2] -= self.shift * own[2:]
        seen = self.window_scorer(PicturePixels(picture), to_xyxy(own))
        if seen is None:
            return None
        drawn = to_cxcywh(seen.box)
        drawn[:2] += self.shift * drawn[2:]
        drawn[2:] *= self.factor
        found = to_xyxy(drawn)
        away = float(np.hypot(*(drawn - to_cxcywh(box))[:2]))
        near = away < _FAR * size_of(box) and abs(math.log(size_of(found) / size_of(box))) < _FAR
        error = math.hypot(_ERROR * (1.0 + _ERROR_GROWTH * max(0.0, _CLEAR - seen.score)), _DRAWN_PX / self.size)
        return Seen(seen.score, found if near and seen.score > _SURE else None, error)


def know(window_scorer: WindowScorer | None, picture: Picture, box: FloatArray) -> KnownShape | None:
    """The known shape of an anchor's sign; None if the detector rejects it as a sign, or its box is too different."""
    seen = None if window_scorer is None else window_scorer(PicturePixels(picture), box)
    if window_scorer is None or seen is None or seen.score < _SURE_ANCHOR or iou_each(seen.box, box)[0] < _SAME:
        return None
    person, detector = to_cxcywh(box), to_cxcywh(seen.box)
    return KnownShape(window_scorer, (person - detector)[:2] / detector[2:], person[2:] / detector[2:], size_of(box))
