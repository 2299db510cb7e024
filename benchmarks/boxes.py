"""How boxes lie in others."""

from __future__ import annotations

import numpy as np

from tsr_engine.geometry.boxes import area, intersection, iou
from tsr_engine.records import FloatArray
from tsr_engine.track_table import BoolArray


def share_inside(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Share of the area of each of (n, 4) boxes inside each of (m, 4) others, shape (n, m)."""
    return np.asarray(intersection(boxes, others) / np.maximum(area(boxes)[:, None], 1e-9))


def lies_elsewhere(boxes: FloatArray, places: FloatArray) -> BoolArray:
    """Whether each of (n, 4) boxes is on none of (m, 4) places: not half inside one, and with an IoU below 0.3."""
    return np.asarray(~((share_inside(boxes, places) >= 0.5) | (iou(boxes, places) >= 0.3)).any(axis=1))
