"""The log-odds of a detector's scores, fitted on scenes without training."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tsr_engine.geometry.boxes import iou
from tsr_engine.records import FloatArray
from tsr_engine.training.public.candidates import fit_calibration


def fit_log_odds(scenes: Iterable[tuple[FloatArray, FloatArray, FloatArray]]) -> tuple[float, float]:
    """``c0, c1`` of ``log-odds = c0 * score + c1``; boxes with an IoU of 0.3 to 0.5 with a sign do not count.

    Args:
        scenes: for each, boxes (n, 4), their scores (n,), and the signs' boxes (m, 4).
    """
    scores, labels = [], []
    for boxes, values, signs in scenes:
        overlap = iou(boxes, signs).max(axis=1, initial=0.0)
        clear = (overlap >= 0.5) | (overlap < 0.3)
        scores.append(values[clear])
        labels.append(np.where(overlap[clear] >= 0.5, 1.0, -1.0))
    c0, c1 = fit_calibration(np.concatenate(scores)[:, None], np.concatenate(labels)).tolist()
    return c0, c1
