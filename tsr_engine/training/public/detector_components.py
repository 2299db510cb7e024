"""Trains the components ``detector`` and ``prior`` on scenes and a folder of crops, with held-out figures.

The scenes are split into three parts: most are for training, some for calibration (log-odds, lambda), the rest for
figures. The shipped detector is then trained again on all scenes with that calibration; its figures stay those of
the split.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.log_odds import LogOdds
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.prior import SpatialPrior, learn_weight, parzen, with_prior
from tsr_engine.errors import InputError
from tsr_engine.evaluation.detection import DetectionScore, match, score_detections
from tsr_engine.geometry.boxes import non_overlap
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.gtsrb import read_items
from tsr_engine.io.models import Component
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params.detector import DetectorParams
from tsr_engine.plural import plural
from tsr_engine.records import FloatArray
from tsr_engine.training.progress import Progress, named
from tsr_engine.training.public.candidates import candidates_of, log_odds_of
from tsr_engine.training.public.detector import DetectorPlan, fit_detector

AS_ANNOTATED = DetectorParams(second_core=False, keep_score=-8.0, inset_width=1.0, inset_height=1.0, inset_rise=0.0)
"""Held-out scenes are scored by their annotated boxes with margin."""
Found = tuple[FloatArray, FloatArray, FloatArray]
"""Detections of one scene: boxes (n, 4), raw scores (n,), and ground truth (m, 4)."""
CALIBRATION_SHARE = 1 / 6
REPORT_SHARE = 1 / 4
BANDWIDTH = 0.05
"""Standard deviation of the Parzen kernel, as a share of the picture's sides."""


def split_scenes(scenes: Sequence[Scene], seed: int) -> tuple[list[Scene], list[Scene], list[Scene]]:
    """Scenes for training, calibration and figures; the seed alone decides."""
    order = np.random.default_rng([seed, 7]).permutation(len(scenes))
    report = round(len(scenes) * REPORT_SHARE)
    calibrate = round(len(scenes) * CALIBRATION_SHARE)
    pick = [scenes[i] for i in order]
    return pick[report + calibrate :], pick[report : report + calibrate], pick[:report]


def train_detector(
    scenes: Sequence[Scene], gtsrb: Path | None, seed: int, progress: Progress, plan: DetectorPlan | None = None
) -> Component:
    """Train the component ``detector``.

    Args:
        scenes: annotated scenes of GTSDB.
        gtsrb: folder of crops as further signs; None: scenes only.
        seed: seed of the split and all randomness.
        progress: called with stage, number done and total.
        plan: unset: :class:`DetectorPlan`'s defaults.

    Returns:
        The component; its arrays also hold the detections on the held-out scenes, from which the prior's weight is
        learned.

    Raises:
        InputError: the crops or a picture cannot be read, or the scenes are too few for the split.
    """
    plan = plan or DetectorPlan()
    train, calibrate, report = split_scenes(scenes, seed)
    if not (calibrate and report and any(len(scene.boxes) for scene in train)):
        signs = sum(len(scene.boxes) for scene in scenes)
        raise InputError(
            "Expected scenes with signs for training, and scenes for calibration and for figures; got "
            f"{plural(len(scenes), 'scene')} with {plural(signs, 'sign')}. Name more annotated scenes."
        )
    crops = read_items(gtsrb) if gtsrb is not None else []
    model, record = fit_detector(train, crops, plan, seed, named("held-out model", progress))
    calibration = calibrate_model(model, calibrate, seed, named("calibration", progress))
    model = replace(model, calibration=calibration)
    found = detect_scenes(model, [*calibrate, *report], named("held-out scenes", progress))
    figures = detection_figures(found[len(calibrate) :])
    final, final_record = fit_detector(scenes, crops, plan, seed, named("final model", progress))
    arrays, settings = replace(final, calibration=calibration).to_arrays()
    for name, values in zip(("boxes", "raw", "labels"), _labelled(found), strict=True):
        arrays[f"heldout_{name}"] = values
    data = {
        "scenes": {"source": "GTSDB", **{k: final_record[k] for k in ("scenes", "signs")}},
        "crops": {"source": "GTSRB", "crops": final_record["crops"]},
        "ignored": sum(len(scene.ignored) for scene in scenes),
        "figures_from": {"trained_on": record["scenes"], "calibrated_on": len(calibrate), "reported_on": len(report)},
        "plan": final_record["plan"],
    }
    return Component("detector", arrays, settings, data, figures, seed)


def calibrate_model(model: AcfModel, scenes: Sequence[Scene], seed: int, progress: Progress) -> LogOdds:
    """Log-odds from the candidates on scenes that did not train the model, see :func:`~.candidates.log_odds_of`.

    Every scene is used twice, unchanged and as if taken by another camera, so that 0 means the same for both.
    """
    found = candidates_of(model, scenes, progress)
    return log_odds_of([*found, *candidates_of(model, scenes, progress, np.random.default_rng([seed, 59]))])


def detect_scenes(
    model: AcfModel, scenes: Sequence[Scene], progress: Progress, params: DetectorParams = AS_ANNOTATED
) -> list[Found]:
    """Detect the signs of each scene."""
    detector = AcfDetector(model, params=params)
    found = []
    for number, scene in enumerate(scenes):
        progress("detecting", number, len(scenes))
        seen = detector.detect(read_picture(scene.path))
        found.append((seen.boxes, seen.raw_scores, scene.boxes))
    return found


def detection_figures(
    found: Sequence[Found],
) -> JsonObject:
    """AP at IoU 0.5, recall at three rates of false detections, mean Eq. 7 of the true detections."""
    score = score_detections(found)
    return {**score_figures(score), "mean_eq7": round(mean_error(found), 4)}


def score_figures(score: DetectionScore) -> JsonObject:
    """The values of a precision-recall curve for a table."""
    return {
        "ap50": round(score.average_precision, 4),
        "recall_at_0.03": round(score.recall_at(0.03), 4),
        "recall_at_0.1": round(score.recall_at(0.1), 4),
        "recall_at_1": round(score.recall_at(1.0), 4),
        "signs": score.signs,
        "pictures": score.pictures,
    }


def mean_error(found: Sequence[Found]) -> float:
    """Mean Eq. 7 over the detected signs, in [0, 1]; 1 if there is none."""
    errors = []
    for boxes, raw, truth in found:
        _, which = match(boxes, raw, truth)
        errors += [non_overlap(boxes[d], truth[s])[0, 0] for s, d in enumerate(which) if d >= 0]
    return float(np.mean(errors)) if errors else 1.0


def train_prior(scenes: Sequence[Scene], detector: Component, seed: int, progress: Progress) -> Component:
    """Train the component ``prior``: the Parzen table and ``lambda`` (Eq. 8).

    ``lambda`` is learned from the detector's held-out detections, because its scores on training scenes leave nothing
    to correct. Raw scores are first mapped linearly onto the labels +-1, as Eq. 8 compares them; ``lambda`` is mapped
    back to the raw scale. If all detections for calibration are signs, or none is, ``lambda`` is 0.

    Raises:
        InputError: the scenes cannot be read, or are not those of the detector.
    """
    train, calibrate, report = split_scenes(scenes, seed)
    _require_scenes_of(detector, [*calibrate, *report], seed)
    progress("density", 0, 2)
    size = read_picture(scenes[0].path).shape
    table = parzen(_centres(train, size), BANDWIDTH)
    boxes, raw, labels = (detector.arrays[f"heldout_{n}"].astype(np.float64) for n in ("boxes", "raw", "labels"))
    scene_of, boxes = boxes[:, 0].astype(int), boxes[:, 1:]
    prior = SpatialPrior(table, 0.0)
    values = prior.at(boxes, size[1], size[0])
    learning = scene_of < len(calibrate)
    weight = 0.0
    if len(np.unique(labels[learning])) == 2:
        slope, offset = np.polyfit(raw[learning], labels[learning], 1)
        weight = learn_weight(slope * raw[learning] + offset, values[learning], labels[learning]) / max(slope, 1e-6)
    progress("figures", 1, 2)
    scores = {}
    for name, used in (("raw", 0.0), ("with_prior", weight)):
        results = []
        for number, scene in enumerate(report):
            here = np.flatnonzero(scene_of == len(calibrate) + number)
            final = with_prior(raw[here], values[here], used)
            kept = here[suppress(boxes[here], final, DetectorParams().final_overlap)]
            results.append((boxes[kept], with_prior(raw[kept], values[kept], used), scene.boxes))
        scores[name] = score_figures(score_detections(results))
    whole = parzen(_centres(scenes, size), BANDWIDTH)
    data = {
        "scenes": {"source": "GTSDB", "scenes": len(scenes)},
        "figures_from": {"table": len(train), "lambda": len(calibrate), "reported_on": len(report)},
    }
    return Component("prior", {"table": whole}, {"lambda": round(float(weight), 6)}, data, scores, seed)


def _require_scenes_of(detector: Component, held_out: Sequence[Scene], seed: int) -> None:
    """Refuse scenes that the detector's held-out detections do not come from.

    Raises:
        InputError: fewer than half of the detections on signs are on a sign of these scenes.
    """
    boxes, raw, labels = (detector.arrays[f"heldout_{n}"].astype(np.float64) for n in ("boxes", "raw", "labels"))
    still_on_signs = []
    for number, scene in enumerate(held_out):
        here = boxes[:, 0] == number
        is_hit, _ = match(boxes[here, 1:], raw[here], scene.boxes)
        still_on_signs += is_hit[labels[here] > 0].tolist()
    if 2 * sum(still_on_signs) < np.count_nonzero(labels > 0):
        raise InputError(
            "The prior is learned from the detector's detections on its held-out scenes. These are not them: it has "
            f"learned from other scenes, or with another seed than {seed}. Name its scenes and seed, or train the "
            "detector again."
        )


def _centres(scenes: Sequence[Scene], size: tuple[int, ...]) -> FloatArray:
    boxes = np.concatenate([s.boxes for s in scenes])
    return np.stack([(boxes[:, 0] + boxes[:, 2]) / (2 * size[1]), (boxes[:, 1] + boxes[:, 3]) / (2 * size[0])], axis=1)


def _labelled(
    found: Sequence[Found],
) -> tuple[NDArray[np.generic], ...]:
    """Held-out detections as rows: (scene number, box) float32, raw score float32, label int8."""
    boxes, scores, labels = [], [], []
    for number, (box, raw, truth) in enumerate(found):
        hit, _ = match(box, raw, truth)
        boxes.append(np.concatenate([np.full((len(box), 1), number), box], axis=1))
        scores.append(raw)
        labels.append(np.where(hit, 1, -1))
    return (
        np.concatenate(boxes).astype(np.float32),
        np.concatenate(scores).astype(np.float32),
        np.concatenate(labels).astype(np.int8),
    )
