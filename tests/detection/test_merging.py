"""Windows on one sign are merged into one candidate."""

import numpy as np
import pytest

from tsr_engine.detection.window_merging import SCORE_SCALE, merge_windows
from tsr_engine.geometry.boxes import non_overlap


def test_a_candidate_is_the_weighted_mean_of_the_windows_around_it() -> None:
    boxes = np.array([[10.0, 10, 30, 30], [12.0, 10, 32, 30], [100.0, 100, 130, 130]])
    merged, scores = merge_windows(boxes, np.array([SCORE_SCALE, 0.0, 5.0]), 0.5, 10)
    weight = np.e / (np.e + 1)  # a window whose score is lower by SPREAD counts 1/e
    assert scores.tolist() == [SCORE_SCALE, 5.0]
    assert merged[0] == pytest.approx([10 * weight + 12 * (1 - weight), 10, 30 * weight + 32 * (1 - weight), 30])
    assert merged[1] == pytest.approx(boxes[2])


def test_a_window_of_another_size_is_suppressed_without_weight() -> None:
    boxes = np.array([[10.0, 10, 50, 50], [12.0, 12, 30, 30]])
    merged, _ = merge_windows(boxes, np.array([3.0, 2.0]), 0.5, 10)
    assert merged.tolist() == [[10.0, 10, 50, 50]]


def test_the_best_candidates_come_first_up_to_a_limit() -> None:
    boxes = np.arange(5)[:, None] * 100.0 + np.array([0.0, 0, 20, 20])
    merged, scores = merge_windows(boxes, np.array([1.0, 5.0, 3.0, 2.0, 4.0]), 0.5, 3)
    assert scores.tolist() == [5.0, 4.0, 3.0]
    assert merged == pytest.approx(boxes[[1, 4, 2]])


def test_no_windows_give_no_candidates() -> None:
    merged, scores = merge_windows(np.zeros((0, 4)), np.zeros(0), 0.5, 3)
    assert (merged.shape, scores.shape) == ((0, 4), (0,))


def test_far_apart_scores_do_not_overflow() -> None:
    merged, scores = merge_windows(np.array([[0.0, 0, 20, 20], [0.0, 0, 20, 20.5]]), np.array([1e5, -1e5]), 0.5, 3)
    assert merged.tolist() == [[0.0, 0, 20, 20]]
    assert scores.tolist() == [1e5]


def test_the_mean_is_more_accurate_than_the_best_window() -> None:
    rng = np.random.default_rng(3)
    truth = np.array([100.0, 100, 140, 140])
    best, mean = [], []
    for _ in range(40):
        boxes = truth + np.repeat(rng.normal(0, 4, (20, 2)), 2, axis=0).reshape(20, 4)
        scores = rng.normal(0, 3, 20)
        best.append(float(non_overlap(boxes[scores.argmax()], truth)[0, 0]))
        mean.append(float(non_overlap(merge_windows(boxes, scores, 0.5, 1)[0], truth)[0, 0]))
    assert np.mean(mean) < 0.6 * np.mean(best)
