"""The product of Eq. 3, its traps and its options."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tsr_engine.gating import Gate, HashMemory
from tsr_engine.params import Params
from tsr_engine.params.gate import GateParams
from tsr_engine.records import GateVerdict, Picture

FLAT = np.full((36, 36, 3), 120, np.uint8)
RNG = np.random.default_rng(0)
CROP = RNG.integers(0, 256, (36, 36, 3), dtype=np.uint8)
PAPER = Params.preset("paper").gate


def centre_at(x: float, y: float) -> np.ndarray:
    return np.array([x, y])


def judge(params: GateParams, crop: Picture = CROP, **changes: Any) -> GateVerdict:
    values: dict[str, Any] = {
        "memory": HashMemory.empty().add(RNG.integers(0, 256, (36, 36, 3), dtype=np.uint8)),
        "centre": centre_at(103, 54),
        "previous_centre": centre_at(100, 50),
    }
    return Gate(params).judge(crop, **(values | changes))


def test_the_product_by_hand() -> None:
    # 3-4-5: p_pos = 5 px. A flat crop has magnitude 0, floored at 0.25: symm = 4.
    params = PAPER.model_copy(update={"symmetry_floor": 0.25})
    memory = HashMemory.empty().add(CROP)
    verdict = judge(params, FLAT, memory=memory)
    assert (verdict.symmetry_magnitude, verdict.symmetry, verdict.position_distance) == (0.0, 4.0, 5.0)
    assert verdict.hash_distance == memory.distance(FLAT)
    assert verdict.l_positive == 4.0 * 5.0 * verdict.hash_distance
    assert not verdict.confident


@pytest.mark.parametrize("params", [GateParams(), PAPER])
def test_the_product_uses_the_stored_factors_and_tau_decides(params: GateParams) -> None:
    verdict = judge(params)
    place = verdict.position_distance + params.position_offset
    assert verdict.l_positive == verdict.symmetry * verdict.hash_distance * place
    assert verdict.symmetry == 1.0 / max(verdict.symmetry_magnitude, params.symmetry_floor)
    value = verdict.l_positive
    assert value > 0.0
    memory = HashMemory.empty().add(FLAT)
    value = judge(params, memory=memory).l_positive
    assert judge(params.model_copy(update={"tau": value * 1.001}), memory=memory).confident
    # "L < tau": equality is not confident.
    assert not judge(params.model_copy(update={"tau": value}), memory=memory).confident


def test_a_factor_of_zero_is_confident() -> None:
    memory = HashMemory.empty().add(CROP)
    same = judge(PAPER, memory=memory, centre=centre_at(900, 900))
    assert (same.hash_distance, same.l_positive, same.confident) == (0.0, 0.0, True)
    still = judge(PAPER, centre=centre_at(100, 50))
    assert (still.position_distance, still.l_positive, still.confident) == (0.0, 0.0, True)


def test_with_a_position_offset_a_smooth_prediction_is_judged_by_its_look() -> None:
    params = GateParams(position_offset=2.0)
    other, same = HashMemory.empty().add(FLAT), HashMemory.empty().add(CROP)
    still = judge(params, memory=other, centre=centre_at(100, 50))
    assert still.position_distance == 0.0
    assert still.l_positive == 2.0 * still.symmetry * still.hash_distance > 0.0
    assert not judge(
        params.model_copy(update={"tau": still.l_positive}), memory=other, centre=centre_at(100, 50)
    ).confident
    assert judge(params, memory=same, centre=centre_at(100, 50)).confident


def test_sides_and_camera_shift() -> None:
    params = GateParams()
    moved = judge(params, side=25.0, shift=(3.0, 0.0))
    assert moved.position_distance == pytest.approx(4.0 / 25.0)
    # The crop of 36 px includes a margin of a tenth of the sign's side on each side: the sign has 30 px.
    assert judge(params).position_distance == pytest.approx(5.0 / 30.0)
    assert judge(PAPER, side=25.0, shift=(3.0, 0.0)).position_distance == 5.0
    assert judge(params, side=0.0).position_distance == pytest.approx(5.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("same", [True, False])
def test_values_that_are_not_finite_are_never_confident(bad: float, same: bool) -> None:
    memory = HashMemory.empty().add(CROP if same else FLAT)
    for changes in ({"centre": centre_at(bad, 0)}, {"previous_centre": centre_at(0, bad)}, {"shift": (bad, 0.0)}):
        verdict = judge(GateParams(), memory=memory, **changes)
        assert not verdict.confident
        assert verdict.l_positive == math.inf


def test_small_flat_and_empty_crops() -> None:
    memory = HashMemory.empty().add(CROP)
    for side in (1, 2, 5, 16):
        verdict = judge(GateParams(), np.ascontiguousarray(CROP[:side, :side]), memory=memory)
        assert math.isfinite(verdict.l_positive)
    empty = judge(GateParams(), np.zeros((0, 0, 3), np.uint8), memory=memory)
    assert not empty.confident
    assert empty.l_positive == math.inf


def test_a_gate_needs_a_memory() -> None:
    with pytest.raises(ValueError, match="empty memory"):
        judge(GateParams(), memory=HashMemory.empty())


def test_remember_follows_the_parameters() -> None:
    black, white = np.zeros((9, 9, 3), np.uint8), np.full((9, 9, 3), 200, np.uint8)
    plain, fading = Gate(PAPER), Gate(GateParams(hash_memory=2))
    a = b = HashMemory.empty()
    for crop in (black, black, black, white):
        a, b = plain.remember(a, crop), fading.remember(b, crop)
    assert float(a.mean.mean()) == pytest.approx(50.0)
    assert float(b.mean.mean()) == pytest.approx(100.0)


def test_judging_twice_gives_the_same_verdict() -> None:
    gate, memory = Gate(GateParams()), HashMemory.empty().add(FLAT)
    verdicts = {gate.judge(CROP, memory, centre_at(1, 2), centre_at(3, 4)) for _ in range(3)}
    assert len(verdicts) == 1
    assert verdicts == {Gate(GateParams()).judge(CROP, memory, centre_at(1, 2), centre_at(3, 4))}
