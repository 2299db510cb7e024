"""The detector of [20] of the paper: colour probability model, maximally stable regions, HOG and linear SVMs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.systems.colour_model import ColourModel
from benchmarks.systems.hog_svm import HogSvm, describe_boxes
from benchmarks.systems.proposals import ProposalPlan, propose
from tsr_engine.detection.nms import suppress
from tsr_engine.geometry.boxes import clip
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import Detections, Picture


@dataclass(frozen=True, slots=True)
class ColourMser:
    """The trained parts.

    Attributes:
        colours: the colour probability model.
        plan: settings of the proposals.
        svm: classifier of the proposals.
        calibration: log-odds of being a sign = c0 * decision value + c1.
    """

    colours: ColourModel
    plan: ProposalPlan
    svm: HogSvm
    calibration: tuple[float, float]

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]], settings: JsonMapping) -> ColourMser:
        """The reverse of :meth:`to_arrays`."""
        colours = ColourModel(
            arrays["table"].astype(np.uint8, copy=False),
            arrays["means"].astype(float),
            arrays["covariances"].astype(float),
        )
        c0, c1 = (float(v) for v in settings["calibration"])
        svm = HogSvm(arrays["weights"].astype(np.float32), arrays["offsets"].astype(np.float32))
        return cls(colours, ProposalPlan(**settings["plan"]), svm, (c0, c1))

    def to_arrays(self) -> tuple[dict[str, NDArray[np.generic]], JsonObject]:
        """Arrays and JSON settings."""
        arrays: dict[str, NDArray[np.generic]] = {
            "table": self.colours.table,
            "means": self.colours.means,
            "covariances": self.colours.covariances,
            "weights": self.svm.weights,
            "offsets": self.svm.offsets,
        }
        return arrays, {"plan": asdict(self.plan), "calibration": list(self.calibration)}


class ColourMserDetector:
    """Finds signs in one picture; implements :class:`tsr_engine.protocols.OfflineDetector`."""

    name = "colour, MSER and HOG SVM"

    def __init__(self, model: ColourMser, params: DetectorParams) -> None:
        self.model = model
        self.params = params

    def detect(self, picture: Picture) -> Detections:
        """Detections of one BGR picture, best first; scores are log-odds, there is no prior."""
        found = propose(picture, self.model.colours, self.model.plan, self.params)
        values = self.model.svm.scores(describe_boxes(picture, found.maps, found.boxes))
        c0, c1 = self.model.calibration
        raw = c0 * values + c1
        sane = raw >= self.params.keep_score
        boxes, raw = found.boxes[sane], raw[sane]
        kept = suppress(boxes, raw, self.params.final_overlap, 200)
        boxes = clip(boxes[kept], picture.shape[1], picture.shape[0])
        return Detections(boxes, raw[kept], np.full(len(boxes), 0.5), raw[kept])
