"""Window rescoring: the steps of the offline detector after its scan, on a box that the scan did not find.

An online detector's window gives the place of a sign. It hardly gives its size, or whether it is a sign.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.geometry.boxes import LEAST_SIDE, shorter_side
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray

__all__ = ["WindowRescoring"]

_AROUND = 1.0
"""Border around the box to read, in sides: it covers the patches, and the moves of the edges."""


@dataclass(frozen=True, slots=True)
class WindowRescoring:
    """Moves a box onto the edges of the sign in it, and scores how likely it is a sign.

    Attributes:
        model: the offline detector's model; its cascade is not used.
        box_inset: box inset of the given and the returned boxes.
        passes: number of passes of the box refinement.
    """

    model: AcfModel
    box_inset: BoxInset
    passes: int

    def __call__(self, pixels: PixelSource, box: FloatArray) -> ScoredBox | None:
        """Rescore a box (4,), px; None if the box is too small or not wholly in the picture."""
        loose = self.box_inset.undo(box[None])
        inside = (loose[0, :2] >= 0).all() and (loose[0, 2:] <= [pixels.width, pixels.height]).all()
        if not inside or not shorter_side(box) >= LEAST_SIDE:
            return None
        reach = _AROUND * float((loose[0, 2:] - loose[0, :2]).max())
        x1, y1 = max(0, math.floor(loose[0, 0] - reach)), max(0, math.floor(loose[0, 1] - reach))
        x2 = min(pixels.width, math.ceil(loose[0, 2] + reach))
        y2 = min(pixels.height, math.ceil(loose[0, 3] + reach))
        picture, corner = pixels.crop(x1, y1, x2, y2), np.array([x1, y1, x1, y1], dtype=np.float64)
        refined, raw = self.model.refine(picture, loose - corner, np.zeros(1))
        drawn = self.box_inset.apply(self.model.box_refinement.refine(picture, refined, self.passes) + corner)[0]
        if not shorter_side(drawn) >= LEAST_SIDE:
            return None
        return ScoredBox(drawn, float(raw[0]))
