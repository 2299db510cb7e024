"""Detects signs outside the classifier's classes: one-way, parking, no stopping.

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

COMPONENT: Final = "other_shapes"
MAX_NESTED_RATIO: Final = 0.6
"""A box with less than this share of another box's area may be a sign in a sign, such as the limit in a zone sign: 0.32
to 0.58 on the zone signs of GTSDB."""
_SAME_SIGN_IOU: Final = 0.35
"""IoU above which two boxes show the same sign, unless the known box is a sign in the other."""


class OtherShapes:
    """Finds signs that belong to none of the classes.

    Args:
        model: ACF model that was trained on such signs.
        params: parameters of the main detector. Box inset and box refinement are switched off: the training boxes of
            this model lie at the edges of signs, and the box refinement was trained on other shapes.
    """

    def __init__(self, model: AcfModel, params: DetectorParams) -> None:
        overrides = {"inset_width": 1.0, "inset_height": 1.0, "inset_rise": 0.0, "refine_passes": 0}
        self.detector = AcfDetector(model, params=params.model_copy(update=overrides), nested=MAX_NESTED_RATIO)

    @classmethod
    def from_component(cls, component: TrainedPart, main_model: AcfModel, params: DetectorParams) -> OtherShapes:
        """Make it from a loaded model component and the main detector's model.

        Raises:
            ValueError: an array or setting of the component is missing or has a wrong shape.
        """
        try:
            return cls(
                AcfModel.from_arrays({**main_model.box_refinement.to_arrays(), **component.arrays}, component.params),
                params,
            )
        except KeyError as error:
            raise ValueError(f"The model of other shapes lacks {error.args[0]!r}.") from None

    def detect(self, picture: Picture, known: Detections) -> Detections:
        """Detections of a picture besides the known ones, best first.

        Of two boxes on one sign, the known box stays if it is more likely a sign than not; otherwise the better box
        stays.

        Args:
            picture: BGR, uint8.
            known: the main detector's detections in the picture.

        Raises:
            ValueError: the picture is not uint8 of shape (h, w, 3), or has no pixel.
        """
        found = self.detector.detect(picture)
        if not len(found) or not len(known):
            return found
        score = np.where(known.raw_scores >= 0, np.inf, known.raw_scores)
        same = (iou(found.boxes, known.boxes) > _SAME_SIGN_IOU) & (
            area(known.boxes) >= MAX_NESTED_RATIO * area(found.boxes)[:, None]
        )
        is_worse = same & (score[None] >= found.raw_scores[:, None])
        return found.select(~is_worse.any(axis=1))
