"""Joins two passes over the frames between two anchors: each frame combines both filters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from tsr_engine.follow.sign_follower import Step
from tsr_engine.geometry.boxes import iou_each, to_cxcywh, to_xyxy
from tsr_engine.records import FloatArray

_MIN_AGREEMENT_IOU = 0.3
"""IoU below which two boxes show different objects, so that the more certain one counts and not their mean."""


def join_passes(
    left: tuple[int, FloatArray],
    right: tuple[int, FloatArray],
    forward: Mapping[int, Step],
    backward: Mapping[int, Step],
) -> dict[int, Step]:
    """Join two passes over the frames between two anchors.

    If both passes see the sign, the box is the mean of both, weighted by the inverse of their variances: the two-filter
    form of Kalman smoothing (Fraser & Potter 1969). If one pass sees it, its box counts. If none does, the box is
    interpolated between the nearest frames with a box.

    Args:
        left: frame and box, shape (4,), px, of the earlier anchor.
        right: frame and box, shape (4,), px, of the later anchor.
        forward: steps of the pass from the left anchor, by frame; it may end early.
        backward: steps of the pass from the right anchor, by frame; it may end early.
    """
    known: dict[int, Step] = {}
    for frame in range(left[0] + 1, right[0]):
        seen = [s for s in (forward.get(frame), backward.get(frame)) if s is not None and s.source != "predicted"]
        if seen:
            known[frame] = seen[0] if len(seen) == 1 else _combine(*seen)
    boxes = {left[0]: left[1], **{frame: step.box for frame, step in known.items()}, right[0]: right[1]}
    ordered = sorted(boxes)
    joined = dict(known)
    for before, after in pairwise(ordered):
        for frame in range(before + 1, after):
            hidden = [s for s in (forward.get(frame), backward.get(frame)) if s is not None]
            if not hidden:  # neither pass reaches these frames, because of cuts of the film
                continue
            confidence = max(s.confidence for s in hidden)
            box = interpolate((before, boxes[before]), (after, boxes[after]), frame)
            joined[frame] = Step(box, confidence, "predicted", hidden[0].place_error, hidden[0].size_error, None)
    return joined


def interpolate(before: tuple[int, FloatArray], after: tuple[int, FloatArray], frame: int) -> FloatArray:
    """Interpolate the box of a sign that the camera approaches at constant speed: its inverse size is linear in time.

    The centre moves in proportion to the size, as along the ray from the focus of expansion.
    """
    share = (frame - before[0]) / (after[0] - before[0])
    a, b = to_cxcywh(before[1]), to_cxcywh(after[1])
    size = 1.0 / ((1.0 - share) / a[2:] + share / b[2:])
    total_growth = float(np.sqrt(b[2] * b[3] / (a[2] * a[3])))
    growth = float(np.sqrt(size[0] * size[1] / (a[2] * a[3])))
    along = share if abs(total_growth - 1.0) < 1e-3 else (growth - 1.0) / (total_growth - 1.0)
    return to_xyxy(np.concatenate([a[:2] + along * (b - a)[:2], size]))


def _combine(one: Step, other: Step) -> Step:
    overlap = float(iou_each(one.box, other.box)[0])
    more_certain = max((one, other), key=lambda step: step.confidence)
    if overlap < _MIN_AGREEMENT_IOU:
        return replace(more_certain, confidence=more_certain.confidence * 0.5)
    a, b = to_cxcywh(one.box), to_cxcywh(other.box)
    place = _weight([one.place_error, other.place_error])
    size = _weight([one.size_error, other.size_error])
    centre = a[:2] + place * (b - a)[:2]
    sides = np.exp(np.log(a[2:]) + size * np.log(b[2:] / a[2:]))
    uncertainty = (1.0 - one.confidence) * (1.0 - other.confidence)
    confidence = overlap * (1.0 - uncertainty) + (1.0 - overlap) * more_certain.confidence
    return Step(
        to_xyxy(np.concatenate([centre, sides])),
        confidence,
        more_certain.source,
        min(one.place_error, other.place_error),
        min(one.size_error, other.size_error),
        more_certain.evidence,
    )


def _weight(errors: Sequence[float]) -> float:
    """Weight of the second of two values in their mean."""
    first, second = (max(error, 1e-9) ** -2 for error in errors)
    return float(second / (first + second))
