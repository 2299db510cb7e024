"""Refines the spatial prior and lambda with corrected boxes (section III-A, Eq. 2 and 8)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.prior import SpatialPrior, learn_weight, parzen
from tsr_engine.evaluation.detection import match
from tsr_engine.geometry.boxes import intersection
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.detector_components import BANDWIDTH

__all__ = ["SceneDetections", "blended_table", "held_out_detections", "refined_lambda"]


SceneDetections = tuple[FloatArray, FloatArray, FloatArray]
"""Detections on corrected frames: centres (n, 2) as shares of the picture, raw scores (n,), labels +-1 (n,)."""


def blended_table(
    table: NDArray[np.float32], earlier: int, scenes: Sequence[CorrectedScene], sizes: Sequence[tuple[int, int]]
) -> tuple[NDArray[np.float32], int]:
    """The Parzen table of earlier and corrected signs together.

    A Parzen estimate is a mean of kernels, so two of them are averaged with their numbers of centres as weights. Each
    frame of a corrected track counts as one sign, as each picture of a sign in GTSDB does.

    Args:
        table: the earlier table.
        earlier: number of its centres.
        scenes: corrected frames.
        sizes: (width, height) of each frame's picture.

    Returns:
        The table, and the number of its centres.
    """
    centres = [
        [(box[0] + box[2]) / (2 * width), (box[1] + box[3]) / (2 * height)]
        for scene, (width, height) in zip(scenes, sizes, strict=True)
        for box in scene.scene.boxes
    ]
    if not centres:
        return table, earlier
    new = parzen(np.clip(centres, 0.0, 1.0), BANDWIDTH).astype(np.float64)
    old = table.astype(np.float64)
    density = earlier * old / old.sum() + len(centres) * new / new.sum()
    return (density / density.max()).astype(np.float32), earlier + len(centres)


def held_out_detections(model: AcfModel, scenes: Sequence[CorrectedScene], progress: Progress) -> SceneDetections:
    """Detections of a model that has not learned from the frames; those that touch an ignored region are left out."""
    detector = AcfDetector(model, params=DetectorParams(second_core=False, keep_score=-8.0))
    centres, scores, labels = [np.zeros((0, 2))], [np.zeros(0)], [np.zeros(0)]
    for done, scene in enumerate(scenes):
        progress("detections for lambda", done, len(scenes))
        picture = read_picture(scene.scene.path)
        seen = detector.detect(picture)
        hit, _ = match(seen.boxes, seen.raw_scores, scene.scene.boxes)
        known = hit | ~(intersection(seen.boxes, scene.scene.ignored) > 0).any(axis=1)
        middle = (seen.boxes[:, :2] + seen.boxes[:, 2:]) / 2 / np.array([picture.shape[1], picture.shape[0]])
        centres.append(middle[known])
        scores.append(seen.raw_scores[known])
        labels.append(np.where(hit[known], 1.0, -1.0))
    return np.concatenate(centres), np.concatenate(scores), np.concatenate(labels)


def refined_lambda(
    table: NDArray[np.float32],
    detector_arrays: dict[str, NDArray[np.generic]],
    picture: tuple[int, int],
    detected: SceneDetections,
) -> float | None:
    """``lambda`` by Eq. 8 over the earlier held-out detections and those on corrected frames.

    Args:
        table: the prior.
        detector_arrays: arrays of the component ``detector``, with its held-out detections.
        picture: (width, height) of the pictures of these detections.
        detected: see :func:`held_out_detections`.

    Returns:
        ``lambda`` in units of the raw score; None: there are no true or no false detections.
    """
    prior = SpatialPrior(table, 0.0)
    centres, raw, labels = detected
    values = [prior.at(np.concatenate([centres, centres], axis=1), 1, 1)]
    scores, kinds = [raw], [labels]
    if {"heldout_boxes", "heldout_raw", "heldout_labels"} <= set(detector_arrays):
        boxes = detector_arrays["heldout_boxes"][:, 1:].astype(np.float64)
        values.append(prior.at(boxes, *picture))
        scores.append(detector_arrays["heldout_raw"].astype(np.float64))
        kinds.append(detector_arrays["heldout_labels"].astype(np.float64))
    q, h, y = np.concatenate(values), np.concatenate(scores), np.concatenate(kinds)
    if not ((y > 0).any() and (y < 0).any()):
        return None
    slope, offset = np.polyfit(h, y, 1)
    return learn_weight(slope * h + offset, q, y) / max(float(slope), 1e-6)
