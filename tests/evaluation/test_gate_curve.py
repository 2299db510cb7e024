"""The experiment over tau: rates by hand, and a drawn sign on a textured background."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tsr_engine.evaluation.gate import Candidates, Trial, collection_curve, gate_trials
from tsr_engine.params.gate import GateParams
from tsr_engine.records import GateVerdict


def make_trial(sign: int, genuine: bool, value: float) -> Trial:
    return Trial(sign, 0, genuine, GateVerdict(0.5, 2.0, 1.0, 1.0, value, confident=value < 15))


def test_rates_by_hand() -> None:
    # Sign 1: genuine 1, 3; patches 2, 10. Sign 2, of another video: genuine 5; patch 4.
    trials = [
        ("a", make_trial(1, True, 1)),
        ("a", make_trial(1, True, 3)),
        ("a", make_trial(1, False, 2)),
        ("a", make_trial(1, False, 10)),
    ]
    trials += [("b", make_trial(1, True, 5)), ("b", make_trial(1, False, 4))]
    curve = collection_curve(trials, np.array([1.0, 3.5, 6.0]))
    # tau 1: nothing is below it. tau 3.5: sign a 2/2 and 1/2, sign b 0/1 and 1/1. tau 6: 1, 1 and 1/2, 0.
    np.testing.assert_allclose(curve.genuine, [0.0, 0.5, 1.0])
    np.testing.assert_allclose(curve.patches, [1.0, 0.75, 0.25])
    np.testing.assert_allclose(curve.correct, [0.5, 0.625, 0.625])
    assert curve.best_tau == 3.5
    with pytest.raises(ValueError, match="needs genuine candidates and patches"):
        collection_curve([("a", make_trial(1, True, 1))], np.array([1.0]))


def test_a_drawn_sign_differs_from_its_surroundings() -> None:
    rng = np.random.default_rng(0)
    ground = cv2.GaussianBlur(rng.integers(0, 256, (240, 320, 3)).astype(np.float32), (0, 0), 3)
    ground = cv2.normalize(ground, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    frames, truth = [], {}
    for k in range(9):
        x, y, r = 120 + 3 * k, 100 - k, 15 + k
        picture = ground.copy()
        cv2.circle(picture, (x, y), r, (30, 30, 190), -1, cv2.LINE_AA)
        cv2.circle(picture, (x, y), round(0.7 * r), (235, 235, 235), -1, cv2.LINE_AA)
        frames.append((k, picture))
        truth[k] = {7: np.array([x - r, y - r, x + r + 1, y + r + 1], dtype=np.float64)}
    chosen = Candidates(patches=10, copies=2)
    trials = gate_trials(frames, truth, GateParams(), chosen, seed=1)
    # Three frames of history, then 1 + 2 genuine candidates and 10 patches a frame.
    assert [sum(t.genuine for t in trials), sum(not t.genuine for t in trials)] == [6 * 3, 6 * 10]
    assert {t.frame for t in trials} == set(range(3, 9))
    curve = collection_curve([("drawn", t) for t in trials], np.array([GateParams().tau]))
    assert curve.correct[0] > 0.9
    assert gate_trials(frames, truth, GateParams(), chosen, seed=1) == trials
    small = Candidates(smallest=100.0)
    assert gate_trials(frames, truth, GateParams(), small) == []
