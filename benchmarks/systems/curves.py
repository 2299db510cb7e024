"""Precision-recall curves as results keep them, and who is ahead in a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from tsr_engine.evaluation.detection import DetectionScore

__all__ = ["RATES", "outdone", "plain"]

RATES: Final = ("0.03", "0.1", "1.0")
"""False detections a picture at which recall is reported."""


def plain(curve: DetectionScore) -> dict[str, Any]:
    """What the report needs of a curve."""
    some = np.unique(np.linspace(0, max(0, len(curve.recall) - 1), 400).astype(int)) if len(curve.recall) else []
    return {
        "ap": curve.average_precision,
        "recall_at": {rate: curve.recall_at(float(rate)) for rate in RATES},
        "recall": np.round(curve.recall[some], 5).tolist(),
        "precision": np.round(curve.precision[some], 5).tolist(),
    }


def outdone(
    curves: Mapping[str, Mapping[str, Any]], ours: Sequence[str], columns: Mapping[str, tuple[Callable[..., Any], int]]
) -> list[str]:
    """Sentences on where the best of ours is behind another row.

    Args:
        curves: rows by name.
        ours: names of our rows.
        columns: title -> (value of a row or None, +1 if higher is better, -1 if lower).
    """
    said = []
    for title, (value, sign) in columns.items():
        mine = [value(curves[name]) for name in ours if name in curves and value(curves[name]) is not None]
        if not mine:
            continue
        best = max(mine, key=lambda v: sign * v)
        ahead = [
            name
            for name, row in curves.items()
            if name not in ours and value(row) is not None and sign * value(row) > sign * best
        ]
        if ahead:
            said.append(f"{title}: behind {' and '.join(ahead)}")
    return said
