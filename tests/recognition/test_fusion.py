import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsr_engine.params import FusionParams
from tsr_engine.recognition.fusion import Fusion, frame_weight


def params(mode: str, delta: float = 20.0, scale: float = 48.0) -> FusionParams:
    return FusionParams.model_validate({"fusion_mode": mode, "fusion_delta": delta, "fusion_scale": scale})


def votes_for(**shares: float) -> np.ndarray:
    p = np.zeros(43, dtype=np.float32)
    for name, share in shares.items():
        p[int(name[1:])] = share
    return p


class TestWeight:
    def test_eq_5_by_hand(self) -> None:
        # 1 / (20 sqrt(2 pi)) = 0.0199471; 28 px is one delta below s_c: times exp(-1/2) = 0.0120985.
        assert frame_weight(48, params("scale")) == pytest.approx(0.01994711402, rel=1e-9)
        assert frame_weight(28, params("scale")) == pytest.approx(0.01209853623, rel=1e-9)
        assert frame_weight(88, params("scale")) == pytest.approx(0.01994711402 * math.exp(-2), rel=1e-9)

    def test_clamped_is_eq_5_below_the_centre_and_full_above(self) -> None:
        for side in (5.0, 20.0, 47.9):
            assert frame_weight(side, params("clamped")) == frame_weight(side, params("scale"))
        assert frame_weight(300, params("clamped")) == frame_weight(48, params("scale"))

    def test_equal_ignores_the_scale(self) -> None:
        assert frame_weight(5, params("equal")) == frame_weight(500, params("equal")) == 1.0

    def test_a_tiny_weight_does_not_vanish(self) -> None:
        assert frame_weight(1000, params("scale", delta=0.5)) > 0

    @pytest.mark.parametrize(("delta", "scale"), [(0.1, 48.0), (0.1, 1e-300), (0.1, 1000.0), (1000.0, 1e-300)])
    def test_the_ends_of_the_ranges_give_weights(self, delta: float, scale: float) -> None:
        for side in (0.0, 1.0, 48.0, 16384.0):
            assert 0 < frame_weight(side, params("scale", delta, scale)) < math.inf

    def test_a_delta_whose_square_vanishes_is_refused(self) -> None:
        with pytest.raises(ValueError, match="fusion_delta"):
            params("scale", delta=1e-300)

    @pytest.mark.parametrize("side", [-1.0, math.nan, math.inf])
    def test_a_bad_scale_is_refused(self, side: float) -> None:
        with pytest.raises(ValueError, match="scale"):
            frame_weight(side, params("equal"))


class TestFusion:
    def test_eq_4_by_hand(self) -> None:
        # Two small wrong frames (28 px) against one right frame at the full weight (48 px), delta 20:
        # class 1: 2 * 0.6 * e^-1/2 + 0.2 = 0.9278; class 2: 2 * 0.4 * e^-1/2 + 0.8 = 1.2852 (times the peak).
        state = Fusion.start(params("scale"))
        state, first = state.update(votes_for(c1=0.6, c2=0.4), 28)
        state, _ = state.update(votes_for(c1=0.6, c2=0.4), 28)
        state, last = state.update(votes_for(c1=0.2, c2=0.8), 48)
        assert (first.class_id, first.runner_up) == (1, 2)
        assert (last.class_id, last.runner_up) == (2, 1)
        peak = 0.01994711402
        assert last.votes[1] / peak == pytest.approx(0.92783679, rel=1e-6)
        assert last.votes[2] / peak == pytest.approx(1.28522453, rel=1e-6)
        assert last.share == pytest.approx(1.28522453 / (1.28522453 + 0.92783679), rel=1e-6)
        assert last.weight == pytest.approx(peak)
        assert last.scale == 48.0

    def test_with_equal_weights_the_majority_wins(self) -> None:
        state = Fusion.start(params("equal"))
        for p, side in ((votes_for(c1=0.7, c2=0.3), 28), (votes_for(c1=0.7, c2=0.3), 28), (votes_for(c2=1), 48)):
            state, record = state.update(p, side)
        assert record.votes[[1, 2]] == pytest.approx([1.4, 1.6], rel=1e-6)
        assert record.class_id == 2

    def test_a_state_is_not_changed_by_its_updates(self) -> None:
        start = Fusion.start(params("clamped"))
        once, _ = start.update(votes_for(c3=1), 30)
        twice, _ = once.update(votes_for(c4=1), 30)
        assert start.votes.sum() == 0
        assert once.votes[4] == 0
        with pytest.raises(ValueError, match="read-only"):
            twice.votes[0] = 1

    def test_ties_go_to_the_lower_class(self) -> None:
        _, record = Fusion.start(params("equal")).update(votes_for(c9=0.5, c7=0.5), 30)
        assert (record.class_id, record.runner_up) == (7, 9)

    @pytest.mark.parametrize(
        ("p", "message"),
        [
            (np.ones(42), "shape"),
            (np.full(43, np.nan), "finite"),
            (np.full(43, -0.1), "finite"),
            (np.zeros(43), "all zero"),
        ],
    )
    def test_bad_probabilities_are_refused(self, p: Any, message: str) -> None:
        with pytest.raises(ValueError, match=message):
            Fusion.start(params("equal")).update(p, 30)

    @settings(deadline=None, max_examples=40)
    @given(
        st.lists(st.tuples(st.integers(0, 42), st.floats(1, 400)), min_size=1, max_size=30),
        st.sampled_from(["scale", "equal", "clamped"]),
        st.floats(1, 100),
    )
    def test_votes_are_the_weighted_sum_in_any_mode(self, frames: list, mode: str, delta: float) -> None:
        settings = params(mode, delta)
        state, expected = Fusion.start(settings), np.zeros(43)
        for class_id, side in frames:
            state, record = state.update(votes_for(**{f"c{class_id}": 0.75, f"c{(class_id + 1) % 43}": 0.25}), side)
            expected[class_id] += 0.75 * frame_weight(side, settings)
            expected[(class_id + 1) % 43] += 0.25 * frame_weight(side, settings)
        np.testing.assert_allclose(record.votes, expected, rtol=1e-12)
        assert record.class_id == int(np.argmax(record.votes))
        assert 0 < record.share <= 1
        assert record.runner_up != record.class_id
