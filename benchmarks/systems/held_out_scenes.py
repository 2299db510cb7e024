"""Scenes that the shipped detector's model was not trained on, with the detections that training kept of them.

Training keeps the detections of its model before it trains once more on all scenes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.experiment import Data, Skip
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.prior import SpatialPrior, parzen, with_prior
from tsr_engine.io.gtsdb import Scene, read_gtsdb
from tsr_engine.io.models import Component, load_component
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray
from tsr_engine.training.public.detector_components import BANDWIDTH, split_scenes

ACF_IS = (
    "\n*ACF* is our offline detector as shipped: the paper's cascade on aggregated channel features, and our further "
    "steps on its candidates (refine-and-verify stage, sign verifier score, box refinement; docs/models.md). No row is "
    "the cascade alone, which accepts many false candidates by design.\n"
)
"""The report's explanation of the rows of our detector."""

DetectionResults = list[tuple[FloatArray, FloatArray, FloatArray]]
"""Per scene: boxes (n, 4), scores (n,), best first, and the signs' boxes (m, 4)."""


@dataclass(frozen=True, slots=True)
class HeldOut:
    """The split of the shipped models.

    Attributes:
        detector: the detector component, with the detections on held-out scenes.
        prior: the prior component, with lambda.
        train: training scenes of the model.
        calibrate: calibration scenes of its scores.
        report: all other scenes.
    """

    detector: Component
    prior: Component
    train: Sequence[Scene]
    calibrate: Sequence[Scene]
    report: Sequence[Scene]

    def detections(self, *, prior: bool) -> DetectionResults:
        """Detections in the report scenes, without or with a spatial prior of the training scenes."""
        rows = self.detector.arrays["heldout_boxes"].astype(float)
        scores = self.detector.arrays["heldout_raw"].astype(float)
        scene_of, boxes = rows[:, 0].astype(int), rows[:, 1:]
        if prior:
            height, width = read_picture(self.report[0].path).shape[:2]
            signs = np.concatenate([scene.boxes for scene in self.train])
            middles = (signs[:, :2] + signs[:, 2:]) / (2 * np.array([width, height]))
            values = SpatialPrior(parzen(middles, BANDWIDTH), 0.0).at(boxes, width, height)
            scores = with_prior(scores, values, float(self.prior.params["lambda"]))
        results = []
        for number, scene in enumerate(self.report, len(self.calibrate)):
            here = np.flatnonzero(scene_of == number)
            kept = here[suppress(boxes[here], scores[here], DetectorParams().final_overlap)]
            results.append((boxes[kept], scores[kept], scene.boxes))
        return results


def held_out(data: Data) -> HeldOut:
    """Split the scenes as in the training of the shipped detector.

    Raises:
        Skip: there are no scenes, or they are not those of the training.
    """
    detector = load_component("detector")
    train, calibrate, report = split_scenes(read_gtsdb(data.need("gtsdb")), detector.seed or 0)
    known = detector.data["figures_from"]
    if (known["calibrated_on"], known["reported_on"]) != (len(calibrate), len(report)):
        raise Skip(f"the models report on {known['reported_on']} scenes of another folder than this one.")
    return HeldOut(detector, load_component("prior"), train, calibrate, report)
