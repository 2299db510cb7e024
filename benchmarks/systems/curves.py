"""Precision-recall curves in stored results, and comparisons of rows of a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.evaluation.detection import DetectionScore
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.records import FloatArray

_MAX_POINTS: Final = 800
RATES: Final = ("0.03", "0.1", "1.0")
"""Numbers of false detections per picture at which recall is reported."""


def recall_at(rate: str) -> Callable[[JsonMapping], float | None]:
    """The recall of a row at one of :data:`RATES`."""
    return lambda row: row["recall_at"][rate]


def curve_figures(curve: DetectionScore) -> JsonObject:
    """The values of a curve that the report needs."""
    some = _corners(curve.recall)
    return {
        "ap": curve.average_precision,
        "recall_at": {rate: curve.recall_at(float(rate)) for rate in RATES},
        "recall": np.round(curve.recall[some], 5).tolist(),
        "precision": np.round(curve.precision[some], 5).tolist(),
    }


def _corners(recall: FloatArray) -> NDArray[np.int64]:
    """Indices of the points for a drawing; between two true detections, precision only falls."""
    if not len(recall):
        return np.zeros(0, np.int64)
    finds = np.flatnonzero(np.diff(recall))
    corners = np.unique(np.concatenate([[0], finds, finds + 1, [len(recall) - 1]]))
    chosen = np.unique(np.linspace(0, len(corners) - 1, min(_MAX_POINTS, len(corners))).astype(int))
    return np.asarray(corners[chosen], np.int64)


def columns_behind(
    curves: Mapping[str, JsonMapping],
    ours: Sequence[str],
    columns: Mapping[str, tuple[Callable[[JsonMapping], float | None], int]],
) -> list[str]:
    """Sentences on columns in which the best of our rows is worse than another row.

    Args:
        curves: rows by name.
        ours: names of our rows.
        columns: title -> (value of a row or None, +1 if higher is better, -1 if lower).
    """
    sentences = []
    for title, (value, sign) in columns.items():
        mine = [v for name in ours if name in curves and (v := value(curves[name])) is not None]
        if not mine:
            continue
        best = max(mine, key=lambda v: sign * v)
        ahead = [
            name
            for name, row in curves.items()
            if name not in ours and (v := value(row)) is not None and sign * v > sign * best
        ]
        if ahead:
            sentences.append(f"{title}: behind {' and '.join(ahead)}")
    return sentences
