"""Overlaps of boxes: pairwise, all with all, and of invalid boxes."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from tsr_engine.geometry.boxes import iou, iou_each

SQUARE = (0.0, 0.0, 10.0, 10.0)
HALF = (5.0, 0.0, 15.0, 10.0)


def test_known_overlaps() -> None:
    others = [SQUARE, HALF, (10.0, 0.0, 20.0, 10.0), (2.0, 2.0, 4.0, 4.0), (5.0, 5.0, 5.0, 9.0), (9.0, 9.0, 1.0, 1.0)]
    wanted = [1.0, 1 / 3, 0.0, 0.04, 0.0, 0.0]
    assert_allclose(iou([SQUARE], others), [wanted])
    assert_allclose(iou_each([SQUARE] * len(others), others), wanted)


def test_pairwise_overlaps_are_the_diagonal() -> None:
    corners = np.random.default_rng(1).uniform(-50, 50, (2, 40, 4))
    a, b = np.concatenate([corners[..., :2], corners[..., :2] + 1 + abs(corners[..., 2:])], axis=-1)
    assert_array_equal(iou_each(a, b), np.diag(iou(a, b)))
    assert iou_each(np.zeros((0, 4)), np.zeros((0, 4))).shape == (0,)
    assert iou(a, np.zeros((0, 4))).shape == (40, 0)
