"""Gated optimal assignment of detections to predicted boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from tsr_engine.geometry.boxes import iou, shorter_side, to_cxcywh
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.records import FloatArray, Prediction

_FORBIDDEN = 1e6
"""Cost of a pair outside the gate: above any sum of admissible costs, so that it never displaces admissible pairs."""


@dataclass(frozen=True, slots=True)
class Gates:
    """Conditions for a detection to match a prediction; see ``TrackingParams``."""

    iou: float
    centre: float
    sigmas: float
    centre_max: float
    size: float

    @classmethod
    def of(cls, params: TrackingParams) -> Gates:
        """The gates of the parameters."""
        return cls(params.iou_gate, params.centre_gate, params.gate_sigmas, params.centre_gate_max, params.size_gate)


def association_cost(predictions: list[Prediction], boxes: FloatArray, gates: Gates) -> FloatArray:
    """Cost of every pair, shape (n, m); inf outside the gates, and for boxes without area.

    The cost of pairs that overlap is ``1 - IoU`` in [0, 1]. That of pairs that are only near is ``1 + distance``: the
    distance of the centres, divided by the geometric mean of the sides of both boxes.
    """
    n, m = len(predictions), len(boxes)
    if n == 0 or m == 0:
        return np.zeros((n, m))
    expected = np.array([p.box for p in predictions])
    overlap = iou(expected, boxes)
    a, b = to_cxcywh(expected)[:, None], to_cxcywh(boxes)[None]
    has_area = shorter_side(boxes) > 0
    b[:, ~has_area, 2:] = 1.0  # avoids roots and logarithms of invalid sizes; the result is not admitted
    side = (a[..., 2] * a[..., 3] * b[..., 2] * b[..., 3]) ** 0.25
    distance = np.hypot(a[..., 0] - b[..., 0], a[..., 1] - b[..., 1]) / np.maximum(side, 1e-9)
    # The place of a track without detections is uncertain, so its gate grows with its covariance, up to a limit.
    std = np.array([np.sqrt(max(p.covariance[0, 0], p.covariance[1, 1])) for p in predictions])[:, None]
    limit = np.clip(gates.sigmas * std / np.maximum(side, 1e-9), gates.centre, max(gates.centre, gates.centre_max))
    ratio = np.exp(np.abs(np.log(a[..., 2:] / b[..., 2:])).max(axis=-1))
    cost = np.where(overlap >= gates.iou, 1.0 - overlap, 1.0 + distance)
    admissible = ((overlap >= gates.iou) | (distance <= limit)) & (ratio <= gates.size) & has_area
    return np.where(admissible, cost, np.inf)


def assign(cost: FloatArray) -> list[tuple[int, int]]:
    """Pairs (row, column) with the least total cost, among the assignments with the most finite pairs.

    Args:
        cost: shape (n, m); inf forbids a pair.
    """
    if cost.size == 0:
        return []
    rows, columns = linear_sum_assignment(np.where(np.isfinite(cost), cost, _FORBIDDEN))
    return [(int(r), int(c)) for r, c in zip(rows, columns, strict=True) if np.isfinite(cost[r, c])]


def associate(
    predictions: list[Prediction], boxes: FloatArray, scores: FloatArray, high: float, low: float, gates: Gates
) -> dict[int, int]:
    """Assign detections to predictions in two passes: first those with high scores, then those with low scores.

    The second pass keeps tracks alive by weak detections (as in ByteTrack, Zhang et al. 2022).

    Args:
        predictions: one prediction for each track.
        boxes: shape (n, 4).
        scores: shape (n,).
        high: least score of the first pass.
        low: least score of the second pass.
        gates: limits on admissible pairs.

    Returns:
        Index of the prediction -> row of the detection.
    """
    cost = association_cost(predictions, boxes, gates)
    matched: dict[int, int] = {}
    for in_pass in (scores >= high, (scores < high) & (scores >= low)):
        rows: NDArray[np.int64] = np.array([i for i in range(len(predictions)) if i not in matched], dtype=np.int64)
        columns = np.flatnonzero(in_pass)
        if not len(rows) or not len(columns):
            continue
        for r, c in assign(cost[np.ix_(rows, columns)]):
            matched[int(rows[r])] = int(columns[c])
    return matched
