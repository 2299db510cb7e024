"""A boosted cascade on histograms of oriented gradients alone, in the manner of Viola and Jones with HOG features.

This is VJ+HOG of the paper's Fig. 9: grey picture, HOG blocks of many sizes in a sliding window, boosted trees, early
rejection. It has neither colour nor a refine-and-verify stage. Window, scales and search bands are those of the ACF
detector.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.systems.hog_blocks import WINDOW
from benchmarks.systems.hog_scan import HogLevel, levels, scales_of, scan
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.trees import UNIT, TreeEnsemble
from tsr_engine.geometry.boxes import clip, iou
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import Detections, FloatArray, Picture

LEVEL_LIMIT: Final = 1000
"""Largest number of windows of one level."""
MAX_WINDOWS: Final = 4000
"""Largest number of windows of a picture for suppression."""


@dataclass(frozen=True, slots=True)
class HogCascade:
    """The trained parts.

    Attributes:
        cascade: trees of depth 2 with rejection thresholds.
        calibration: shape (2,): log-odds of being a sign = c0 * score + c1.
    """

    cascade: TreeEnsemble
    calibration: tuple[float, float]

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]], settings: JsonMapping) -> HogCascade:
        """The reverse of :meth:`to_arrays`."""
        cascade = TreeEnsemble(
            arrays["features"].astype(np.int32),
            arrays["thresholds"].astype(np.uint8),
            arrays["leaves"].astype(np.int16),
            arrays["rejection"].astype(np.int32),
            WINDOW.cells,
        )
        c0, c1 = (float(v) for v in settings["calibration"])
        return cls(cascade, (c0, c1))

    def to_arrays(self) -> tuple[dict[str, NDArray[np.generic]], JsonObject]:
        """Arrays and JSON settings."""
        arrays: dict[str, NDArray[np.generic]] = {
            "features": self.cascade.features,
            "thresholds": self.cascade.thresholds,
            "leaves": self.cascade.leaves,
            "rejection": self.cascade.rejection,
        }
        return arrays, {"calibration": list(self.calibration)}


@dataclass(frozen=True, slots=True)
class Survivors:
    """Windows of one picture that pass a cascade.

    Attributes:
        boxes: shape (n, 4).
        scores: shape (n,), half log-odds.
        places: shape (n, 3): level, row and column.
        levels: the levels by index, if kept.
    """

    boxes: FloatArray
    scores: FloatArray
    places: NDArray[np.int64]
    levels: Mapping[int, HogLevel]


def search(picture: Picture, cascade: TreeEnsemble, params: DetectorParams, keep: bool = False) -> Survivors:
    """All windows of a picture that pass a cascade.

    Args:
        picture: BGR.
        cascade: see :func:`benchmarks.systems.hog_scan.scan`.
        params: only ``min_width`` and the band of rows of far signs are used.
        keep: whether to keep the levels, for training.
    """
    height, width = picture.shape[:2]
    boxes, scores, places = [np.zeros((0, 4))], [np.zeros(0)], [np.zeros((0, 3), np.int64)]
    kept: dict[int, HogLevel] = {}
    for level in levels(picture, scales_of(width, height, params.min_width)):
        y, x, score = scan(level, cascade, _band(level, params, height))
        if not len(y):
            continue
        if len(y) > LEVEL_LIMIT:
            best = np.sort(np.argpartition(-score, LEVEL_LIMIT)[:LEVEL_LIMIT])
            y, x, score = y[best], x[best], score[best]
        boxes.append(level.boxes(y, x))
        scores.append(score / UNIT)
        places.append(np.stack([np.full(len(y), level.index), y, x], axis=1))
        if keep:
            kept[level.index] = level
    every = np.concatenate(scores)
    best = np.argsort(-every, kind="stable")[:MAX_WINDOWS]
    return Survivors(np.concatenate(boxes)[best], every[best], np.concatenate(places)[best], kept)


def _band(level: HogLevel, params: DetectorParams, height: int) -> tuple[int, int] | None:
    """Rows of windows to search; far signs are near the horizon."""
    if WINDOW.sign / level.scale_y >= params.far_share * height:
        return None
    low, high = (share * height * level.scale_y / WINDOW.shrink for share in (params.far_top, params.far_bottom))
    return int(low) + WINDOW.pad, int(high) + WINDOW.pad - WINDOW.cells + 1


class HogCascadeDetector:
    """Finds signs in one picture; implements :class:`tsr_engine.protocols.OfflineDetector`."""

    name = "hog cascade"

    def __init__(self, model: HogCascade, params: DetectorParams) -> None:
        self.model = model
        self.params = params

    def detect(self, picture: Picture) -> Detections:
        """Detections of one BGR picture, best first; scores are log-odds, there is no prior."""
        found = search(picture, self.model.cascade, self.params)
        c0, c1 = self.model.calibration
        every = c0 * found.scores + c1
        kept = suppress(found.boxes, every, self.params.final_overlap, 100)
        kept = kept[every[kept] >= self.params.keep_score]
        boxes = merged(found.boxes, found.scores, found.boxes[kept])
        boxes = clip(boxes, picture.shape[1], picture.shape[0])
        return Detections(boxes, every[kept], np.full(len(boxes), 0.5), every[kept])


def merged(boxes: FloatArray, scores: FloatArray, kept: FloatArray) -> FloatArray:
    """Kept boxes (m, 4), each replaced by the mean of boxes with an IoU above 0.6, weighted by the exponential score.

    Windows lie on a grid, and their mean is closer to the sign (as in the grouping of rectangles of usual cascades).
    """
    out = kept.copy()
    for i, box in enumerate(kept):
        near = iou(boxes, box)[:, 0] >= 0.6
        weight = np.exp(np.minimum(scores[near] - scores[near].max(), 0.0))
        out[i] = weight @ boxes[near] / weight.sum()
    return out
