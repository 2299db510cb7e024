"""Figures of boxes over the frames in which a sign is visible, its life."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from benchmarks.following.methods import interpolate_linearly
from benchmarks.following.visible_signs import Sign
from tsr_engine.geometry.boxes import iou_each
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray

GOOD = 0.7
"""IoU of a box that needs no correction."""
NEAR = 3
"""Number of frames by which an end may be missed, and in which a box may lie on no sign."""
MAX_ACTIONS = 8

Boxes = Mapping[int, FloatArray]


def overlaps(sign: Sign, boxes: Boxes) -> dict[int, float]:
    """IoU in each frame of the life; 0 without a box."""
    return {k: float(iou_each(boxes[k], box)[0]) if k in boxes else 0.0 for k, box in sign.life.items()}


def figures_of(sign: Sign, boxes: Boxes) -> dict[str, float]:
    """Shares of the life by IoU, whether both ends are correct, and whether the box ran away.

    A box has run away in a frame after or before all annotated frames of the sign, or if it hardly overlaps the sign.
    """
    found = np.array(list(overlaps(sign, boxes).values()))
    life = sorted(sign.life)
    ends = min(boxes) - life[0], max(boxes) - life[-1]
    # Annotated frames outside the life also show the sign: it is too narrow, or leaves the picture.
    early, late = min(sign.rows), max(sign.rows)
    met = (ends[0] <= NEAR and min(boxes) >= early - NEAR) and (ends[1] >= -NEAR and max(boxes) <= late + NEAR)
    run = longest = 0
    for k in range(min(boxes), max(boxes) + 1):
        away = k in boxes and (not early <= k <= late or (k in sign.rows and iou_each(boxes[k], sign.rows[k])[0] < 0.1))
        run = run + 1 if away else 0
        longest = max(longest, run)
    return {
        "iou70": float((found >= GOOD).mean()),
        "iou50": float((found >= 0.5).mean()),
        "ends_met": float(met),
        "runaway": float(longest > NEAR),
    }


def actions(sign: Sign, start: int, fill: Callable[[Boxes], Boxes]) -> int:
    """Number of boxes to draw until every frame of the life has an IoU of 0.7, at most ``MAX_ACTIONS``.

    Each further box is drawn in the frame with the lowest IoU.

    Args:
        sign: the sign.
        start: frame of the first box.
        fill: computes all boxes from the drawn ones.
    """
    drawn = {start: sign.life[start]}
    for done in range(1, MAX_ACTIONS + 1):
        found = overlaps(sign, fill(drawn))
        worst = min(found, key=lambda k: (found[k], k))
        if found[worst] >= GOOD:
            return done
        drawn = {**drawn, worst: sign.life[worst]}
    return MAX_ACTIONS


def lines_needed(sign: Sign) -> int:
    """Number of exact keyframes until straight lines between them have an IoU of 0.7 in all frames."""
    frames = sorted(sign.life)
    drawn = {k: sign.life[k] for k in (frames[0], frames[-1])}
    while True:
        found = overlaps(sign, interpolate_linearly(drawn))
        worst = min(found, key=lambda k: (found[k], k))
        if found[worst] >= GOOD:
            return len(drawn)
        drawn[worst] = sign.life[worst]


def mean_of(rows: Sequence[Mapping[str, float]]) -> JsonObject:
    """Mean of each figure, and the number of rows."""
    return {name: float(np.mean([row[name] for row in rows])) for name in rows[0]} | {"starts": len(rows)}
