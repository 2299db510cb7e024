"""Gates and optimality of the assignment."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsr_engine.records import Prediction
from tsr_engine.tracking.assignment import Gates, assign, associate, association_cost

GATES = Gates(iou=0.2, centre=0.6, sigmas=3.0, centre_max=1.5, size=2.0)


def predicted(x: float, y: float, side: float = 20.0, std: float = 1.0) -> Prediction:
    return Prediction(np.array([x, y, x + side, y + side]), np.eye(4) * std**2)


def box(x: float, y: float, w: float = 20.0, h: float | None = None) -> np.ndarray:
    return np.array([x, y, x + w, y + (w if h is None else h)])


def test_cost_by_hand() -> None:
    boxes = np.array([box(100, 100), box(110, 100), box(111.9, 108), box(100, 113), box(100, 100, 41)])
    cost = association_cost([predicted(100, 100)], boxes, GATES)[0]
    assert cost[0] == pytest.approx(0.0)
    assert cost[1] == pytest.approx(1 - 1 / 3)
    # IoU 0.138, but the centres are 14.3 px = 0.72 sizes apart: outside.
    assert np.isinf(cost[2])
    # 13 px = 0.65 sizes apart, but the IoU is 7/33: inside.
    assert cost[3] == pytest.approx(1 - 7 / 33)
    # IoU 0.238, but more than twice as wide.
    assert np.isinf(cost[4])


def test_near_without_overlap_costs_more_than_any_overlap() -> None:
    gates = Gates(iou=0.2, centre=1.5, sigmas=0.0, centre_max=1.5, size=2.0)
    cost = association_cost([predicted(100, 100)], np.array([box(125, 100), box(113, 100)]), gates)[0]
    assert cost[0] == pytest.approx(1 + 25 / 20)
    assert cost[1] < 1


def test_boxes_without_area_are_outside() -> None:
    flat, upside_down, nothing = box(100, 100, 20, 0), box(100, 120, 20, -20), np.full(4, np.nan)
    cost = association_cost([predicted(100, 100)], np.array([flat, upside_down, nothing, box(100, 100)]), GATES)[0]
    assert np.isinf(cost[:3]).all()
    assert cost[3] == pytest.approx(0.0)


def test_an_uncertain_prediction_widens_the_gate_up_to_a_limit() -> None:
    far = np.array([box(122, 100), box(135, 100)])
    assert np.isinf(association_cost([predicted(100, 100)], far, GATES)).all()
    reach = association_cost([predicted(100, 100, std=8.0)], far, GATES)[0]
    assert np.isfinite(reach[0])
    assert np.isinf(reach[1])


def test_the_total_cost_is_minimised() -> None:
    # Greedy would take (0, 0) at 0.1 and leave 0.9; the optimum is 0.2 + 0.2.
    assert assign(np.array([[0.1, 0.2], [0.2, 0.9]])) == [(0, 1), (1, 0)]


def test_forbidden_pairs_do_not_prevent_admissible_ones() -> None:
    inf = np.inf
    assert assign(np.array([[inf, inf], [inf, 0.5]])) == [(1, 1)]
    assert assign(np.array([[0.1, inf], [2.0, inf]])) == [(0, 0)]
    assert assign(np.zeros((0, 3))) == []
    # Two expensive pairs are better than one cheap pair.
    assert assign(np.array([[0.1, 2.4], [2.4, inf]])) == [(0, 1), (1, 0)]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 4))
def test_assignment_equals_an_exhaustive_search(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    cost = np.where(rng.random((n, n)) < 0.3, np.inf, rng.uniform(0, 2, (n, n)))

    def value(pairs: list[tuple[int, int]]) -> tuple[int, float]:
        finite = [cost[p] for p in pairs if np.isfinite(cost[p])]
        return -len(finite), float(sum(finite))

    best = min(value(list(enumerate(order))) for order in permutations(range(n)))
    assert value(assign(cost)) == pytest.approx(best)


def test_confident_detections_are_assigned_first() -> None:
    predictions = [predicted(100, 100), predicted(200, 100)]
    boxes = np.array([box(100, 100), box(104, 100), box(202, 100), box(200, 100)])
    scores = np.array([-1.0, 1.0, -1.5, -3.0])
    # The first takes the confident detection, though a weak one fits better; the last is below every threshold.
    assert associate(predictions, boxes, scores, 0.0, -2.0, GATES) == {0: 1, 1: 2}


def test_stacked_signs_are_not_mixed_up() -> None:
    """Two signs on one pole, one above the other; only the lower one is detected."""
    upper, lower = predicted(100, 100), predicted(100, 122)
    assert associate([upper, lower], np.array([box(101, 121)]), np.array([1.0]), 0.0, -2.0, GATES) == {1: 0}
    assert associate([upper], np.array([box(101, 121)]), np.array([1.0]), 0.0, -2.0, GATES) == {}
