"""Collects a model's candidates and their scores on scenes that did not train it, for calibration and evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import minimize

from tsr_engine.detection.acf import AcfDetector, AcfModel
from tsr_engine.detection.log_odds import UNFITTED, LogOdds
from tsr_engine.detection.nms import suppress
from tsr_engine.evaluation.detection import DetectionScore, match, score_detections
from tsr_engine.geometry.boxes import area, intersection, iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray
from tsr_engine.training.progress import Progress
from tsr_engine.training.public.mining import best_overlap
from tsr_engine.training.synthetic.augment import other_camera

__all__ = ["Candidates", "candidates_of", "fit_calibration", "log_odds_of", "score_candidates"]

_ON_A_SIGN: Final = 0.5
_OFF_ALL_SIGNS: Final = 0.3


@dataclass(frozen=True, slots=True)
class Candidates:
    """Candidates of one scene.

    Attributes:
        scene: the scene.
        boxes: refined boxes, shape (n, 4), px.
        verifier: scores of the refine-and-verify stage, shape (n,).
        sign_verifier: scores of the sign verifier, shape (n,).
    """

    scene: Scene
    boxes: FloatArray
    verifier: FloatArray
    sign_verifier: FloatArray

    def raw(self, calibration: LogOdds) -> FloatArray:
        """Log-odds of the candidates, shape (n,)."""
        return calibration.of(self.verifier, np.zeros(len(self.boxes)), self.sign_verifier)


def candidates_of(
    model: AcfModel,
    scenes: Sequence[Scene],
    progress: Progress,
    other_cameras: np.random.Generator | None = None,
    nested: float = 0.0,
) -> list[Candidates]:
    """Collect the candidates of each scene.

    Args:
        model: the detector's model; its log-odds are not used.
        scenes: the scenes to search.
        progress: progress.
        other_cameras: source of changes as by other cameras; None: pictures are not changed.
        nested: see :class:`~tsr_engine.detection.acf.AcfDetector`.

    Raises:
        InputError: a picture cannot be decoded.
    """
    detector = AcfDetector(model, params=DetectorParams(second_core=False), nested=nested)
    out = []
    for number, scene in enumerate(scenes):
        progress("candidates", number, len(scenes))
        picture = read_picture(scene.path)
        if other_cameras is not None:
            picture = other_camera(picture, other_cameras)
        boxes, _ = detector.candidates(picture)
        refined, verified = model.refine_stage.refine_and_verify(picture, boxes)
        out.append(Candidates(scene, refined, verified, model.sign_verifier.scores(picture, refined)))
    return out


def log_odds_of(found: Sequence[Candidates]) -> LogOdds:
    """Fit log-odds to candidates on scenes that did not train the model.

    Only verifier and sign verifier score are used. The weight of the cascade's score differed between two halves of 150
    scenes, and with it fewer signs were found at few false detections. If all candidates are signs, or none is, the
    weights cannot be fitted and are :data:`UNFITTED`.
    """
    scored, labels = [], []
    for one in found:
        overlap = best_overlap(one.boxes, one.scene.boxes)
        on = overlap >= _ON_A_SIGN
        clear = on | ((overlap < _OFF_ALL_SIGNS) & (best_overlap(one.boxes, one.scene.ignored) < _OFF_ALL_SIGNS))
        scored.append(np.stack([one.verifier, one.sign_verifier], axis=1)[clear])
        labels.append(np.where(on[clear], 1.0, -1.0))
    every = np.concatenate(labels)
    if len(np.unique(every)) < 2:
        return UNFITTED
    verifier, sign_verifier, offset = fit_calibration(np.concatenate(scored), every).tolist()
    return LogOdds(verifier, 0.0, sign_verifier, offset)


def fit_calibration(scores: FloatArray, labels: FloatArray, ridge: float = 1e-3) -> FloatArray:
    """Logistic regression ``log-odds = scores @ c[:-1] + c[-1]`` with ``c[:-1] >= 0``.

    scikit-learn's logistic regression cannot keep weights non-negative, and a score that lowers the
    log-odds of a sign would be used against its meaning.

    Args:
        scores: shape (n, k); a higher score means more sign-like.
        labels: shape (n,), +1 sign, -1 not; from scenes that trained none of the scores.
        ridge: strength of the pull of the weights towards 0.

    Returns:
        Shape (k + 1,).
    """
    features = np.concatenate([scores, np.ones((len(scores), 1))], axis=1)

    def loss(c: FloatArray) -> tuple[float, FloatArray]:
        margin = labels * (features @ c)
        value = np.mean(np.logaddexp(0.0, -margin)) + ridge * float(c[:-1] @ c[:-1])
        pull = -labels / (1.0 + np.exp(np.clip(margin, -500, 500)))
        gradient = features.T @ pull / len(labels)
        gradient[:-1] += 2 * ridge * c[:-1]
        return float(value), gradient

    count = scores.shape[1]
    start = np.concatenate([np.full(count, 0.1), [0.0]])
    bounds = [(0.0, None)] * count + [(None, None)]
    return np.asarray(minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds).x)


def score_candidates(found: Sequence[Candidates], raw: Sequence[FloatArray], least: float) -> DetectionScore:
    """Precision and recall of candidates used as detections.

    Detections on ignored regions, or on signs whose longer side is below ``least`` px, are not counted.

    Args:
        found: candidates of each scene.
        raw: their log-odds, shape (n,) each.
        least: smallest longer side of a counted sign, px.
    """
    results = []
    for one, scores in zip(found, raw, strict=True):
        kept = suppress(one.boxes, scores, DetectorParams().final_overlap)
        boxes, scores = one.boxes[kept], scores[kept]
        sides = (one.scene.boxes[:, 2:] - one.scene.boxes[:, :2]).max(axis=1, initial=0.0)
        truth = one.scene.boxes[sides >= least]
        neutral = np.concatenate([one.scene.ignored, one.scene.boxes[sides < least]])
        hit, _ = match(boxes, scores, truth)
        inside = intersection(boxes, neutral) / np.maximum(area(boxes)[:, None], 1e-9)
        touched = np.maximum(inside, iou(boxes, neutral) + _ON_A_SIGN - _OFF_ALL_SIGNS).max(axis=1, initial=0.0)
        counts = hit | (touched < _ON_A_SIGN)
        results.append((boxes[counts], scores[counts], truth))
    return score_detections(results)
