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

from tsr_engine.follow.picture_pixels import PicturePixels
from tsr_engine.follow.template import size_of
from tsr_engine.geometry.boxes import iou_each, to_cxcywh, to_xyxy
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray, Picture

WindowScorer = Callable[[PixelSource, FloatArray], ScoredBox | None]

_MIN_ANCHOR_SCORE: Final = 0.0
"""Log-odds from which an anchor counts as a sign."""
_SAME_IOU: Final = 0.6
"""IoU with the person's box from which the detector's box shows the same object."""
_MIN_SCORE: Final = -1.0
"""Log-odds from which a box of the detector is a measurement."""
_MAX_DEVIATION: Final = 0.35
"""Largest distance of such a box, as a share of the size, and largest change of size, natural logarithm."""
_SIZE_ERROR: Final = 0.05
"""Error of the size of a clear detection, natural logarithm."""
_CLEAR_SCORE: Final = 6.0
"""Log-odds of a clear detection; each unit below adds ``_ERROR_GROWTH`` of the error."""
_ERROR_GROWTH: Final = 0.3
_DRAWN_ERROR_PX: Final = 0.3
"""Error of the person's edges, px; on a small anchor it hides the person's way of drawing."""


@dataclass(frozen=True, slots=True)
class ShapeMeasurement:
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

    def measure(self, picture: Picture, box: FloatArray) -> ShapeMeasurement | None:
        """The detector's result at a box (4,), px; None if the detector cannot score it."""
        detector_box = to_cxcywh(box)
        detector_box[2:] /= self.factor
        detector_box[:2] -= self.shift * detector_box[2:]
        scored = self.window_scorer(PicturePixels(picture), to_xyxy(detector_box))
        if scored is None:
            return None
        drawn = to_cxcywh(scored.box)
        drawn[:2] += self.shift * drawn[2:]
        drawn[2:] *= self.factor
        person_box = to_xyxy(drawn)
        distance = float(np.hypot(*(drawn - to_cxcywh(box))[:2]))
        is_near = (
            distance < _MAX_DEVIATION * size_of(box)
            and abs(math.log(size_of(person_box) / size_of(box))) < _MAX_DEVIATION
        )
        error = math.hypot(
            _SIZE_ERROR * (1.0 + _ERROR_GROWTH * max(0.0, _CLEAR_SCORE - scored.score)), _DRAWN_ERROR_PX / self.size
        )
        return ShapeMeasurement(scored.score, person_box if is_near and scored.score > _MIN_SCORE else None, error)


def match_known_shape(window_scorer: WindowScorer | None, picture: Picture, box: FloatArray) -> KnownShape | None:
    """The known shape of an anchor's sign; None if the detector rejects it as a sign, or its box is too different."""
    scored = None if window_scorer is None else window_scorer(PicturePixels(picture), box)
    if (
        window_scorer is None
        or scored is None
        or scored.score < _MIN_ANCHOR_SCORE
        or iou_each(scored.box, box)[0] < _SAME_IOU
    ):
        return None
    person, detector = to_cxcywh(box), to_cxcywh(scored.box)
    return KnownShape(window_scorer, (person - detector)[:2] / detector[2:], person[2:] / detector[2:], size_of(box))
