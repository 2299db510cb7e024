"""Precision, recall and average precision of detections in single pictures (Eq. 6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.geometry.boxes import iou
from tsr_engine.records import FloatArray


@dataclass(frozen=True, slots=True)
class DetectionScore:
    """A precision-recall curve and the figures derived from it.

    Attributes:
        recall: shape (n,), recall up to each detection, in descending order of score.
        precision: shape (n,), precision up to each detection.
        scores: shape (n,), descending.
        signs: number of annotated signs.
        pictures: number of pictures.
    """

    recall: FloatArray
    precision: FloatArray
    scores: FloatArray
    signs: int
    pictures: int

    @property
    def average_precision(self) -> float:
        """Area under the curve, with each precision replaced by the best at that recall or above (all points)."""
        if not self.signs or not len(self.recall):
            return 0.0
        envelope = np.maximum.accumulate(self.precision[::-1])[::-1]
        steps = np.diff(self.recall, prepend=0.0)
        return float(np.sum(steps * envelope))

    def recall_at(self, false_per_picture: float) -> float:
        """Highest recall with at most this many false detections per picture."""
        rank = np.arange(1, len(self.recall) + 1)
        false = rank - self.recall * self.signs
        allowed = np.nonzero(false <= false_per_picture * self.pictures + 1e-9)[0]
        return float(self.recall[allowed[-1]]) if len(allowed) else 0.0

    def threshold_at(self, false_per_picture: float) -> float:
        """Score threshold for :meth:`recall_at`; infinity if the best detection already exceeds the rate."""
        rank = np.arange(1, len(self.recall) + 1)
        false = rank - self.recall * self.signs
        allowed = np.nonzero(false <= false_per_picture * self.pictures + 1e-9)[0]
        return float(self.scores[allowed[-1]]) if len(allowed) else float("inf")


def match(
    boxes: FloatArray, scores: FloatArray, truth: FloatArray, least_iou: float = 0.5
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Match one picture's detections to its signs greedily, best score first, each sign once.

    Args:
        boxes: detected boxes, shape (n, 4).
        scores: their scores, shape (n,).
        truth: annotated boxes, shape (m, 4).
        least_iou: least IoU of a match.

    Returns:
        Whether each detection is true, shape (n,); the detection that found each sign, or -1, shape (m,).
    """
    hit = np.zeros(len(boxes), np.bool_)
    found = np.full(len(truth), -1, np.int64)
    if not len(boxes) or not len(truth):
        return hit, found
    overlap = iou(boxes, truth)
    for i in np.argsort(-scores, kind="stable"):
        free = np.where(found < 0, overlap[i], -1.0)
        best = int(np.argmax(free))
        if free[best] >= least_iou:
            hit[i] = True
            found[best] = i
    return hit, found


def score_detections(
    results: Sequence[tuple[FloatArray, FloatArray, FloatArray]], least_iou: float = 0.5
) -> DetectionScore:
    """Score the detections of many pictures.

    scikit-learn's functions do not fit: ``precision_recall_curve`` ignores signs without a detection, which lower the
    recall here, and ``average_precision_score`` lacks the envelope that papers on detection use.

    Args:
        results: for each picture the detected boxes (n, 4), their scores (n,) and the annotated boxes (m, 4).
        least_iou: least IoU of a match.
    """
    hits, scores, signs = [], [], 0
    for boxes, values, truth in results:
        hit, _ = match(boxes, values, truth, least_iou)
        hits.append(hit)
        scores.append(values)
        signs += len(truth)
    all_hits = np.concatenate(hits) if hits else np.zeros(0, np.bool_)
    all_scores = np.concatenate(scores).astype(np.float64) if scores else np.zeros(0)
    order = np.argsort(-all_scores, kind="stable")
    true = np.cumsum(all_hits[order])
    rank = np.arange(1, len(order) + 1)
    return DetectionScore(true / max(1, signs), true / rank, all_scores[order], signs, len(results))
