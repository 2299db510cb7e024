import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.detection.random_inputs import random_cells, random_ensemble
from tsr_engine.detection.scan import MAX_SINGLE_WINDOWS, prepare, scan_level
from tsr_engine.detection.trees import NEVER


def plain_scan(cells, ensemble, dense, gains):
    """Scan window by window and node by node, in Python."""
    w = ensemble.window
    corrected = np.minimum(np.floor(cells * gains[:, None, None] + 1e-9), 255).astype(int)
    found = []
    for y in range(cells.shape[1] - w + 1):
        for x in range(cells.shape[2] - w + 1):
            sample = corrected[:, y : y + w, x : x + w].reshape(-1)
            total, alive = 0, True
            for t in range(len(ensemble)):
                k = 0
                for _ in range(ensemble.depth):
                    right = sample[ensemble.features[t, k]] >= ensemble.thresholds[t, k]
                    k = 2 * k + (2 if right else 1)
                total += int(ensemble.leaves[t, k - ensemble.thresholds.shape[1]])
                if t >= dense - 1 and total < ensemble.rejection[t]:
                    alive = False
                    break
            if alive:
                found.append((y, x, total))
    return found


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**30), st.integers(1, 20), st.floats(0.95, 1.1))
def test_the_scan_equals_a_plain_loop_exactly(seed: int, dense: int, gain: float) -> None:
    rng = np.random.default_rng(seed)
    ensemble, cells = random_ensemble(rng), random_cells(rng, 12, 17)
    gains = np.where(np.arange(10) < 3, 1.0, gain)
    y, x, score = scan_level(cells, ensemble, dense, prepare(ensemble, 12, 17, gains))
    assert list(zip(y.tolist(), x.tolist(), score.tolist(), strict=True)) == plain_scan(cells, ensemble, dense, gains)


@pytest.mark.parametrize(("height", "width"), [(6, 6), (6, 40), (13, 13), (14, 14), (50, 9)])
def test_few_and_many_windows_equal_the_plain_loop(height: int, width: int) -> None:
    """One window, one row, the most rows that are scanned singly and one row more, more rows than a band."""
    rng = np.random.default_rng(height)
    ensemble, cells = random_ensemble(rng), random_cells(rng, height, width)
    lenient = ensemble.with_rejection(np.where(np.arange(20) < 12, NEVER, ensemble.rejection))
    for trees in (ensemble, lenient):
        y, x, score = scan_level(cells, trees, 3)
        expected = plain_scan(cells, trees, 3, np.ones(10))
        assert list(zip(y.tolist(), x.tolist(), score.tolist(), strict=True)) == expected


def test_the_sizes_above_lie_on_both_sides_of_the_limit() -> None:
    assert (13 - 5) ** 2 == MAX_SINGLE_WINDOWS < (14 - 5) ** 2


def test_scores_equal_those_of_extracted_windows() -> None:
    rng = np.random.default_rng(3)
    ensemble, cells = random_ensemble(rng), random_cells(rng)
    ensemble = ensemble.with_rejection(np.full(len(ensemble), NEVER))
    y, x, score = scan_level(cells, ensemble, 8)
    assert len(y) == (23 - 5) * (31 - 5)
    windows = np.stack([cells[:, a : a + 6, b : b + 6].reshape(-1) for a, b in zip(y, x, strict=True)])
    assert np.array_equal(ensemble.scores(windows), score)
    assert np.array_equal(ensemble.partial_sums(windows)[:, -1], score)


def test_more_survivors_than_the_first_buffer_holds() -> None:
    rng = np.random.default_rng(5)
    ensemble = random_ensemble(rng).with_rejection(np.full(20, NEVER))
    y, _, _ = scan_level(random_cells(rng, 60, 70), ensemble, 8)
    assert len(y) == 55 * 65


def test_cells_smaller_than_the_window_give_nothing() -> None:
    rng = np.random.default_rng(6)
    y, x, score = scan_level(random_cells(rng, 5, 40), random_ensemble(rng), 8)
    assert len(y) == len(x) == len(score) == 0


def test_trees_of_another_depth_are_refused() -> None:
    rng = np.random.default_rng(7)
    with pytest.raises(ValueError, match="depth 3. Got 2"):
        scan_level(random_cells(rng), random_ensemble(rng, depth=2), 8)
