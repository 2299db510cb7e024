"""Signs outside the classifier's classes, found beside those of the detector: one-way, parking, no stopping.

A second ACF model finds them. Its detections on signs that the detector has found are left out. They have no class.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.geometry.boxes import area, iou
from tsr_engine.params.detector import DetectorParams
from tsr_engine.protocols import TrainedPart
from tsr_engine.records import Detections, Picture

__all__ = ["COMPONENT", "NESTED", "OtherShapes"]

COMPONENT: Final = "other_shapes"
NESTED: Final = 0.6
"""A box with less than this share of another one's area may be a sign that is drawn in a sign, as the limit in a zone
sign is: 0.32 to 0.58 on the zone signs of GTSDB."""
_SAME: Final = 0.35
"""Boxes that overlap more show the same sign, unless the known one is drawn in the other."""


class OtherShapes:
    """Finds signs that none of the classes names.

    Args:
        model: trained on such signs.
        params: of the detector beside which it works; its boxes are annotated at the edges of signs, so that no inset
            applies, and the box refinement knows other shapes.
    """

    def __init__(self, model: AcfModel, params: DetectorParams) -> None:
        own = {"inset_width": 1.0, "inset_height": 1.0, "inset_rise": 0.0, "refine_passes": 0}
        self.detector = AcfDetector(model, params=params.model_copy(update=own), nested=NESTED)

    @classmethod
    def from_component(cls, part: TrainedPart, beside: AcfModel, params: DetectorParams) -> OtherShapes:
        """From a loaded model component, and the model of the detector beside which it works.

        Raises:
            ValueError: the component's arrays or settings are not those of such a model.
        """
        try:
            return cls(AcfModel.from_arrays({**beside.box_refinement.to_arrays(), **part.arrays}, part.params), params)
        except KeyError as error:
            raise ValueError(f"The model of other shapes lacks {error.args[0]!r}.") from None

    def detect(self, picture: Picture, known: Detections) -> Detections:
        """Detections of a BGR picture besides the known ones, best first.

        Of two boxes on one sign the known one stays where it is more likely a sign than not, else the better one.

        Args:
            picture: BGR, uint8.
            known: what the detector has found in the picture.

        Raises:
            ValueError: not uint8 of shape (h, w, 3), or without a pixel.
        """
        found = self.detector.detect(picture)
        if not len(found) or not len(known):
            return found
        score = np.where(known.raw_scores >= 0, np.inf, known.raw_scores)
        same = (iou(found.boxes, known.boxes) > _SAME) & (area(known.boxes) >= NESTED * area(found.boxes)[:, None])
        beaten = same & (score[None] >= found.raw_scores[:, None])
        return found.select(~beaten.any(axis=1))
