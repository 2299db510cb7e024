"""Window rescoring: the steps of the offline detector after its scan, on a box that the scan did not find.

An online detector's window gives the place of a sign. It hardly gives its size, or whether it is a sign.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tsr_engine.detection.acf import AcfModel
from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.geometry.boxes import MIN_SIDE, shorter_side
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray

__all__ = ["WindowRescoring"]

_BORDER_SIDES = 1.0
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
        annotated = self.box_inset.undo(box[None])
        is_inside = (annotated[0, :2] >= 0).all() and (annotated[0, 2:] <= [pixels.width, pixels.height]).all()
        if not is_inside or not shorter_side(box) >= MIN_SIDE:
            return None
        border = _BORDER_SIDES * float((annotated[0, 2:] - annotated[0, :2]).max())
        x1, y1 = max(0, math.floor(annotated[0, 0] - border)), max(0, math.floor(annotated[0, 1] - border))
        x2 = min(pixels.width, math.ceil(annotated[0, 2] + border))
        y2 = min(pixels.height, math.ceil(annotated[0, 3] + border))
        picture, corner = pixels.crop(x1, y1, x2, y2), np.array([x1, y1, x1, y1], dtype=np.float64)
        refined, raw = self.model.refine(picture, annotated - corner, np.zeros(1))
        refined_box = self.box_inset.apply(self.model.box_refinement.refine(picture, refined, self.passes) + corner)[0]
        if not shorter_side(refined_box) >= MIN_SIDE:
            return None
        return ScoredBox(refined_box, float(raw[0]))
