"""Steps from a box to a better one."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.geometry.box_steps import mean_side, move, size_of, steps_between
from tsr_engine.records import FloatArray

BOXES = np.array([[10.0, 10.0, 30.0, 50.0], [0.0, 0.0, 8.0, 8.0]])
TRUTH = np.array([[12.0, 9.0, 34.0, 49.0], [1.0, 0.5, 8.0, 9.0]])


@pytest.mark.parametrize("unit", [size_of(BOXES), mean_side(BOXES)])
def test_steps_lead_to_the_truth(unit: FloatArray) -> None:
    steps = steps_between(BOXES, TRUTH, unit)
    np.testing.assert_allclose(move(BOXES, steps, unit, 1.0), TRUTH)


def test_steps_by_hand() -> None:
    assert steps_between(BOXES[:1], TRUTH[:1], size_of(BOXES[:1])).tolist() == [
        pytest.approx([3 / 20, -1 / 40, np.log(22 / 20), 0.0])
    ]
    assert mean_side(BOXES).tolist() == [[np.sqrt(800.0)], [8.0]]
    far = move(BOXES[:1], np.array([[9.0, 0.0, 9.0, -9.0]]), size_of(BOXES[:1]), 0.5)
    np.testing.assert_allclose(size_of(far), [[20 * np.exp(0.5), 40 * np.exp(-0.5)]])
    np.testing.assert_allclose((far[:, 0] + far[:, 2]) / 2, 30.0)
