"""Candidates on scenes not used for training: calibration data and counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tsr_engine.detection.log_odds import UNFITTED
from tsr_engine.io.gtsdb import Scene
from tsr_engine.records import FloatArray
from tsr_engine.training.public.candidates import Candidates, log_odds_of, score_candidates

SIGN, SMALL, BOARD = [100.0, 100, 140, 140], [200.0, 100, 212, 112], [300.0, 100, 380, 160]


def scene() -> Scene:
    return Scene("0.jpg", Path("0.jpg"), np.array([SIGN, SMALL]), np.array([201, 201]), np.array([BOARD]))


def candidates(boxes: list[list[float]], scores: list[float]) -> Candidates:
    values = np.array(scores)
    return Candidates(scene(), np.array(boxes).reshape(-1, 4), values, values)


def count_signs(boxes: list[list[float]], scores: list[float]) -> tuple[FloatArray, int]:
    found = [candidates(boxes, scores)]
    score = score_candidates(found, [one.raw(UNFITTED) for one in found], 20.0)
    return score.scores, score.signs


def test_detections_on_ignored_or_small_signs_do_not_count() -> None:
    part_of_the_board, near_the_small_sign = [310.0, 110, 330, 130], [199.0, 99, 212, 113]
    nowhere = [500.0, 100, 530, 130]
    scores, signs = count_signs([SIGN, BOARD, part_of_the_board, near_the_small_sign, nowhere], [5, 4, 3, 2, 1])
    assert signs == 1
    assert scores.tolist() == [10, 2]  # the sign, and a false detection


def test_missed_signs_and_scenes_without_candidates_count() -> None:
    empty = candidates([], [])
    score = score_candidates([empty, candidates([SIGN], [1.0])], [np.zeros(0), np.array([2.0])], 20.0)
    assert (score.signs, score.pictures, score.recall_at(0.2)) == (2, 2, 0.5)


def test_log_odds_do_not_use_ignored_places() -> None:
    rng = np.random.default_rng(0)
    nowhere = [500.0, 100, 530, 130]
    plain = [candidates([SIGN, nowhere], [rng.normal(2, 1), rng.normal(-2, 1)]) for _ in range(40)]
    with_boards = [
        Candidates(
            one.scene, np.concatenate([one.boxes, [BOARD]]), np.append(one.verifier, 9), np.append(one.verifier, 9)
        )
        for one in plain
    ]
    assert log_odds_of(with_boards) == log_odds_of(plain)
    assert log_odds_of(plain).of(np.array([3.0]), np.zeros(1), np.array([3.0]))[0] > 1


def test_log_odds_need_signs_and_false_candidates() -> None:
    assert log_odds_of([candidates([SIGN], [1.0])]) == UNFITTED
    assert log_odds_of([candidates([[500.0, 100, 530, 130]], [1.0])]) == UNFITTED
