"""The path of a sign as estimated by its filter."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.follow.sign_path import SignPath
from tsr_engine.geometry.boxes import iou_each


@pytest.mark.parametrize("sides", [(22.0, 185.0), (185.0, 22.0)])
def test_a_long_board_keeps_its_shape(sides: tuple[float, float]) -> None:
    box = np.array([300.0, 200.0, 300.0 + sides[0], 200.0 + sides[1]])
    path = SignPath(box, (1280, 720), "forward")
    for _ in range(3):
        path.predict(1.0, (0.0, 0.0))
        path.correct(box, 0.02)
        assert iou_each(path.box, box)[0] > 0.9
