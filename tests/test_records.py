"""Records refuse invalid values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tsr_engine.records import Detections


def make_detections(**changed: Any) -> Detections:
    columns = {"raw_scores": np.zeros(3), "prior": np.full(3, 0.5), "scores": np.zeros(3)}
    return Detections(**{"boxes": np.tile([1.0, 2.0, 30.0, 40.0], (3, 1)), **columns, **changed})


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("edge", range(4))
def test_a_box_is_finite(edge: int, odd: float) -> None:
    boxes = make_detections().boxes.copy()
    boxes[1, edge] = odd
    with pytest.raises(ValueError, match=rf"Detections.boxes must be finite. Got \[.*{odd}.*\] in row 1"):
        make_detections(boxes=boxes)


@pytest.mark.parametrize("name", ["raw_scores", "prior", "scores"])
def test_a_score_may_be_unknown_but_not_infinite(name: str) -> None:
    assert len(make_detections(**{name: np.array([0.0, np.nan, 1.0])})) == 3
    with pytest.raises(ValueError, match=rf"Detections.{name} must not be infinite. Got -inf in row 2"):
        make_detections(**{name: np.array([0.0, np.nan, -np.inf])})


def test_shapes_fit_together() -> None:
    with pytest.raises(ValueError, match=r"Detections.boxes must have shape \(n, 4\)"):
        make_detections(boxes=np.zeros((3, 5)))
    with pytest.raises(ValueError, match=r"Detections.prior must have shape \(3,\)"):
        make_detections(prior=np.zeros(2))
