"""Steps from a box to a corrected one: the targets and outputs of box regressions."""

from __future__ import annotations

import numpy as np

from tsr_engine.records import FloatArray


def size_of(boxes: FloatArray) -> FloatArray:
    """Width and height of boxes (n, 4), px, shape (n, 2)."""
    return np.asarray(boxes[:, 2:] - boxes[:, :2])


def mean_side(boxes: FloatArray) -> FloatArray:
    """Geometric mean of width and height of boxes (n, 4), px, at least 1, shape (n, 1)."""
    return np.asarray(np.sqrt(np.maximum(1.0, np.prod(size_of(boxes), axis=1, keepdims=True))))


def move(boxes: FloatArray, steps: FloatArray, unit: FloatArray, max_step: float) -> FloatArray:
    """Boxes (n, 4) moved and resized.

    Args:
        boxes: shape (n, 4), px.
        steps: shape (n, 4): displacement of the centre in units; natural logarithms of the new width and height in
            units.
        unit: px, shape (n, 1), or (n, 2) for x and y.
        max_step: limit on the absolute value of a step.
    """
    steps = np.clip(steps, -max_step, max_step)
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2 + steps[:, :2] * unit
    half = unit * np.exp(steps[:, 2:]) / 2
    return np.concatenate([middle - half, middle + half], axis=1)


def steps_between(boxes: FloatArray, truth: FloatArray, unit: FloatArray) -> FloatArray:
    """Steps (n, 4) by which :func:`move` moves boxes (n, 4) onto the true boxes (n, 4)."""
    shift = ((truth[:, :2] + truth[:, 2:]) - (boxes[:, :2] + boxes[:, 2:])) / 2 / unit
    return np.concatenate([shift, np.log(size_of(truth) / unit)], axis=1)
