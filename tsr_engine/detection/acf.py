"""``M_off``: the offline detector on aggregated channel features (section III-A, Eq. 1 and 2).

The steps are: pyramid, cascade over all windows, suppression, refine-and-verify stage on the remaining windows, sign
verifier score, calibration to log-odds, box refinement of likely signs, prior.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import local

import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import check_picture
from tsr_engine.channels.pyramid import Band, Level, PyramidPlan, build_pyramid, level_scales
from tsr_engine.channels.scratch import Scratch
from tsr_engine.detection.log_odds import LogOdds
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.prior import SpatialPrior, effective_weight, with_prior
from tsr_engine.detection.refine.box_inset import BoxInset
from tsr_engine.detection.refine.box_refinement import BoxRefinement
from tsr_engine.detection.refine.sign_verifier import SignVerifier
from tsr_engine.detection.refine.stage import RefineStage
from tsr_engine.detection.scan import ScanNodes, prepare, scan_level
from tsr_engine.detection.scan_schedule import bands_of_frame, rows_of
from tsr_engine.detection.trees import UNIT, TreeEnsemble
from tsr_engine.detection.window import Window
from tsr_engine.detection.window_merging import merge_windows
from tsr_engine.geometry.boxes import MIN_SIDE, clip, iou, shorter_side
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params.detector import DetectorParams, PriorParams
from tsr_engine.protocols import TrainedPart
from tsr_engine.records import Detections, FloatArray, Picture

MAX_CANDIDATES_PER_LEVEL = 2000
"""Largest number of candidates of one level."""
MAX_CACHED_LEVELS = 400
"""Number of cached levels: enough for several picture sizes."""
_SAME_SIGN_IOU = 0.5
"""IoU from which a detection counts as the sign that was expected there."""
_STRIP_OVERLAP = 0.75
"""Overlap of the strips of a scan in turn, on each side, in windows: half a window and the filters' reach."""


@dataclass(frozen=True, slots=True)
class AcfModel:
    """All trained parts of the detector.

    Attributes:
        window: the cascade's window.
        plan: the pyramid that it was trained on.
        cascade: trees with rejection thresholds.
        refine_stage: refinement and verification.
        sign_verifier: separates signs from objects of the same shape.
        box_refinement: moves boxes onto the edges of signs.
        calibration: turns the three scores into log-odds of being a sign.
    """

    window: Window
    plan: PyramidPlan
    cascade: TreeEnsemble
    refine_stage: RefineStage
    sign_verifier: SignVerifier
    box_refinement: BoxRefinement
    calibration: LogOdds

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]], settings: JsonMapping) -> AcfModel:
        """Make a model from the arrays and settings of a model component (see :meth:`to_arrays`).

        Raises:
            KeyError: an array or setting is missing.
            ValueError: shapes do not fit together.
        """
        window = Window(**settings["window"])
        plan = PyramidPlan(
            shrink=window.shrink,
            per_octave=int(settings["per_octave"]),
            computed_per_octave=int(settings["computed_per_octave"]),
            lambdas=tuple(float(v) for v in settings["lambdas"]),
        )
        calibration = LogOdds(*(float(v) for v in settings["calibration"]))
        refine_stage = RefineStage(
            arrays["step_weights"].astype(np.float32),
            arrays["step_biases"].astype(np.float32),
            _ensemble(arrays, "verifier", int(settings["verifier_window"])),
        )
        cascade = _ensemble(arrays, "cascade", window.cells)
        sign_verifier, box_refinement = SignVerifier.from_arrays(arrays), BoxRefinement.from_arrays(arrays)
        return cls(window, plan, cascade, refine_stage, sign_verifier, box_refinement, calibration)

    def refine(self, picture: Picture, boxes: FloatArray, cascade: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Refine and score candidates.

        Args:
            picture: BGR, uint8.
            boxes: candidates, shape (n, 4), px.
            cascade: their cascade scores, shape (n,).

        Returns:
            Refined boxes (n, 4), and log-odds of being a sign (n,).
        """
        refined, verified = self.refine_stage.refine_and_verify(picture, boxes)
        return refined, self.calibration.of(verified, cascade, self.sign_verifier.scores(picture, refined))

    def to_arrays(self) -> tuple[dict[str, NDArray[np.generic]], JsonObject]:
        """Arrays and JSON settings from which :meth:`from_arrays` makes the same model."""
        arrays: dict[str, NDArray[np.generic]] = {
            "step_weights": self.refine_stage.weights.astype(np.float16),
            "step_biases": self.refine_stage.biases,
            **self.sign_verifier.to_arrays(),
            **self.box_refinement.to_arrays(),
        }
        for name, ensemble in (("cascade", self.cascade), ("verifier", self.refine_stage.verifier)):
            arrays[f"{name}_features"] = ensemble.features.astype(np.uint16)
            arrays[f"{name}_thresholds"] = ensemble.thresholds
            arrays[f"{name}_leaves"] = ensemble.leaves
            arrays[f"{name}_rejection"] = ensemble.rejection
        settings = {
            "window": {
                "cells": self.window.cells,
                "shrink": self.window.shrink,
                "sign": self.window.sign,
                "pad": self.window.pad,
            },
            "per_octave": self.plan.per_octave,
            "computed_per_octave": self.plan.computed_per_octave,
            "lambdas": list(self.plan.lambdas),
            "calibration": self.calibration.to_list(),
            "verifier_window": self.refine_stage.verifier.window,
        }
        return arrays, settings


def _ensemble(arrays: Mapping[str, NDArray[np.generic]], name: str, window: int) -> TreeEnsemble:
    return TreeEnsemble(
        arrays[f"{name}_features"].astype(np.int32),
        arrays[f"{name}_thresholds"].astype(np.uint8),
        arrays[f"{name}_leaves"].astype(np.int16),
        arrays[f"{name}_rejection"].astype(np.int32),
        window,
    )


class AcfDetector:
    """Finds signs in one picture, without state; implements :class:`tsr_engine.protocols.OfflineDetector`.

    Args:
        model: the trained parts.
        prior: spatial prior of signs; None: no prior.
        params: parameters of the detector.
        prior_params: parameters of the prior.
        nested: ratio of areas, smaller to larger, below which two overlapping windows both stay candidates. In [0, 1];
            0: only the better one stays.
    """

    name = "acf"

    def __init__(
        self,
        model: AcfModel,
        prior: SpatialPrior | None = None,
        params: DetectorParams | None = None,
        prior_params: PriorParams | None = None,
        nested: float = 0.0,
    ) -> None:
        self.model = model
        self.prior = prior
        self.params = params or DetectorParams()
        self.prior_params = prior_params or PriorParams()
        self.nested = nested
        self.box_inset = BoxInset.of(self.params)
        self.window = model.window.reaching(self.params.beyond_edge)
        self._nodes: dict[tuple[int, int, int], ScanNodes] = {}
        self._thread_local = local()
        self._pool = ThreadPoolExecutor(1, "tsr-scan") if self.params.second_core else None

    @classmethod
    def from_components(
        cls, detector: TrainedPart, prior: TrainedPart | None, params: DetectorParams, prior_params: PriorParams
    ) -> AcfDetector:
        """Make a detector from loaded model components.

        Raises:
            ValueError: an array or setting of an ACF detector is missing or has a wrong shape.
        """
        try:
            model = AcfModel.from_arrays(detector.arrays, detector.params)
            spatial = None
            if prior is not None:
                spatial = SpatialPrior(prior.arrays["table"].astype(np.float32), float(prior.params["lambda"]))
        except KeyError as error:
            raise ValueError(f"The detector's model lacks {error.args[0]!r}.") from None
        return cls(model, spatial, params, prior_params)

    @property
    def prior_weight(self) -> float:
        """``lambda`` of Eq. 2: the parameter's value, or the learned one; 0 if the prior is off."""
        return effective_weight(self.prior, self.prior_params)

    def detect(self, picture: Picture) -> Detections:
        """Detections of one BGR picture, best final score first.

        ``raw_scores`` are log-odds of being a sign; boxes below ``keep_score`` are left out. A picture smaller than a
        sign has no detections.

        Raises:
            ValueError: the picture is not uint8 of shape (h, w, 3), or has no pixel.
        """
        return self._detect(picture, self._pool)

    def detect_single_core(self, picture: Picture) -> Detections:
        """:meth:`detect` on the calling thread alone, for callers that have a picture for each core."""
        return self._detect(picture, None)

    def detect_part(self, picture: Picture, frame: int) -> Detections:
        """Detections in the part of a picture that the schedule searches in frame number ``frame``.

        ``scan_turns`` frames cover all scales and rows once; :meth:`revisit` adds the signs that are known already.
        Runs on the calling thread alone.

        Raises:
            ValueError: the picture is not uint8 of shape (h, w, 3), or has no pixel.
        """
        return self._detect(picture, None, frame)

    def revisit(self, picture: Picture, found: Detections, expected: FloatArray) -> Detections:
        """Detections of :meth:`detect_part`, and of expected signs that it did not find.

        Each expected box without a detection goes through the steps after the scan, as if the scan had found it.

        Args:
            picture: BGR, uint8.
            found: result of :meth:`detect_part` for this picture.
            expected: expected boxes, shape (n, 4), px, with the box inset applied.
        """
        size = np.tile(expected[:, 2:] - expected[:, :2], 2)
        outside = np.concatenate([-expected[:, :2], expected[:, 2:] - picture.shape[1::-1]], axis=1)
        is_searchable = (outside <= self.params.beyond_edge * size).all(axis=1)
        missed = expected[is_searchable & (iou(expected, found.boxes) < _SAME_SIGN_IOU).all(axis=1)]
        if not len(missed):
            return found
        revisited = self._refine_candidates(picture, self.box_inset.undo(missed), np.zeros(len(missed)))
        return self._suppress(found.joined(revisited))

    def _detect(self, picture: Picture, pool: ThreadPoolExecutor | None, frame: int | None = None) -> Detections:
        check_picture(picture)
        return self._suppress(self._refine_candidates(picture, *self._candidates(picture, pool, frame)))

    def _refine_candidates(self, picture: Picture, boxes: FloatArray, cascade: FloatArray) -> Detections:
        """Detections of candidates (n, 4) with cascade scores (n,), in their order, before suppression."""
        height, width = picture.shape[:2]
        refined, raw = self.model.refine(picture, boxes, cascade)
        is_likely = raw >= self.params.keep_score
        refined = self.model.box_refinement.refine(picture, refined[is_likely], self.params.refine_passes)
        refined = self.box_inset.apply(refined)
        refined, raw = clip(refined, width, height), raw[is_likely]
        is_large_enough = shorter_side(refined) >= MIN_SIDE
        refined, raw = refined[is_large_enough], raw[is_large_enough]
        prior = np.full(len(raw), 0.5) if self.prior is None else self.prior.at(refined, width, height)
        return Detections(refined, raw, prior, with_prior(raw, prior, self.prior_weight))

    def _suppress(self, found: Detections) -> Detections:
        """The detections after suppression, best final score first."""
        return found.select(suppress(found.boxes, found.scores, self.params.final_overlap))

    def candidates(self, picture: Picture) -> tuple[FloatArray, FloatArray]:
        """Merged candidates of the cascade: boxes (n, 4) and scores (n,), best first; see :mod:`window_merging`."""
        return self._candidates(picture, self._pool)

    def _candidates(
        self, picture: Picture, pool: ThreadPoolExecutor | None, frame: int | None = None
    ) -> tuple[FloatArray, FloatArray]:
        scales, bands = self.search(picture.shape[1], picture.shape[0])
        if frame is not None and self.params.scan_turns > 1 and len(scales):
            boxes, scores = self._scan_part(picture, scales, bands, frame)
        elif pool is None:
            boxes, scores = self._scan(picture, scales, bands, 0, 1)
        else:
            other = pool.submit(self._scan, picture, scales, bands, 1, 2)
            boxes, scores = self._scan(picture, scales, bands, 0, 2)
            more_boxes, more_scores = other.result()
            boxes, scores = np.concatenate([boxes, more_boxes]), np.concatenate([scores, more_scores])
        return merge_windows(boxes, scores, self.params.first_overlap, self.params.refine_limit, self.nested)

    def _scan_part(
        self, picture: Picture, scales: FloatArray, bands: list[Band], frame: int
    ) -> tuple[FloatArray, FloatArray]:
        _, smallest = next(self.model.plan.computed_groups(len(scales)))
        reach = [_STRIP_OVERLAP * self.model.window.side / scale for scale in scales]
        searched = bands_of_frame(bands, smallest, reach, frame, self.params.scan_turns)
        first, last = rows_of(searched, picture.shape[0])
        if first >= last:
            return np.zeros((0, 4)), np.zeros(0)
        within = [None if band is None else (band[0] - first, band[1] - first) for band in searched]
        boxes, scores = self._scan(picture[first:last], scales, within, 0, 1)
        return boxes + np.array([0, first, 0, first]), scores

    def search(self, width: int, height: int) -> tuple[FloatArray, list[Band]]:
        """Scales to search in a picture of width x height px, and the band of rows in px for each.

        Small signs are far away and therefore near the horizon, so their scales have a narrower band.
        """
        window = self.model.window
        top = window.sign / self.params.min_width
        scales = level_scales(top, window.side / min(width, height), self.model.plan.per_octave)
        bands = []
        for scale in scales:
            far = window.sign / scale < self.params.far_share * height
            low, high = (self.params.far_top, self.params.far_bottom) if far else (0.0, 1.0)
            bands.append((low * height, high * height))
        return scales, bands

    def nodes_for(self, level: Level) -> ScanNodes:
        """The cascade's nodes for a level, cached, because every picture of a video has the same levels."""
        key = (level.index, level.cells.shape[1], level.cells.shape[2])
        nodes = self._nodes.get(key)
        if nodes is None:
            if len(self._nodes) > MAX_CACHED_LEVELS:
                self._nodes.clear()
            nodes = prepare(self.model.cascade, level.cells.shape[1], level.cells.shape[2], level.gains)
            self._nodes[key] = nodes
        return nodes

    def _scratch(self) -> Scratch:
        """Working memory of the calling thread."""
        if not hasattr(self._thread_local, "scratch"):
            self._thread_local.scratch = Scratch()
        scratch: Scratch = self._thread_local.scratch
        return scratch

    def _scan(
        self, picture: Picture, scales: FloatArray, bands: Sequence[Band | None], part: int, parts: int
    ) -> tuple[FloatArray, FloatArray]:
        window = self.window
        boxes, scores = [np.zeros((0, 4))], [np.zeros(0)]
        levels = build_pyramid(picture, scales, self.model.plan, bands, part, parts, window.pad, self._scratch())
        for level in levels:
            y, x, score = scan_level(level.cells, self.model.cascade, self.params.dense_trees, self.nodes_for(level))
            if not len(y):
                continue
            if len(y) > MAX_CANDIDATES_PER_LEVEL:
                best = np.sort(np.argpartition(-score, MAX_CANDIDATES_PER_LEVEL)[:MAX_CANDIDATES_PER_LEVEL])
                y, x, score = y[best], x[best], score[best]
            boxes.append(window.to_boxes(y, x, level))
            scores.append(score / UNIT)
        return np.concatenate(boxes), np.concatenate(scores)
