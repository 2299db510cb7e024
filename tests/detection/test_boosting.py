import numpy as np
import pytest

from tsr_engine.detection.boosting import BoostingPlan, boost
from tsr_engine.detection.trees import NEVER, TreeEnsemble


def two_classes(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Positives: byte 7 far exceeds byte 21, or byte 40 lies in a band. The rest is noise."""
    x = rng.integers(0, 256, (4 * n, 160), dtype=np.uint8)
    wanted = ((x[:, 7].astype(int) - x[:, 21]) > 60) | ((x[:, 40] > 100) & (x[:, 40] < 130))
    return x[wanted][:n], x[~wanted][:n]


def test_it_learns_and_generalises() -> None:
    rng = np.random.default_rng(0)
    good, bad = two_classes(rng, 1500)
    ensemble = boost(good, bad, BoostingPlan(80, depth=3, feature_share=0.5), np.random.default_rng(1), 4)
    new_good, new_bad = two_classes(rng, 800)
    assert (ensemble.scores(new_good) > 0).mean() > 0.93
    assert (ensemble.scores(new_bad) < 0).mean() > 0.93


def test_a_tree_finds_the_best_split() -> None:
    rng = np.random.default_rng(2)
    x = rng.integers(0, 256, (600, 40), dtype=np.uint8)
    wanted = x[:, 13] >= 77
    ensemble = boost(x[wanted], x[~wanted], BoostingPlan(1, depth=1, feature_share=1.0), rng, 2)
    assert ensemble.features[0, 0] == 13
    above, below = x[wanted][:, 13].min(), x[~wanted][:, 13].max()
    assert below < ensemble.thresholds[0, 0] <= above
    assert ensemble.leaves[0, 0] < 0 < ensemble.leaves[0, 1]


def test_the_seed_decides() -> None:
    good, bad = two_classes(np.random.default_rng(3), 300)
    plan = BoostingPlan(5, feature_share=0.3)
    a, b = (boost(good, bad, plan, np.random.default_rng(9), 4) for _ in range(2))
    c = boost(good, bad, plan, np.random.default_rng(10), 4)
    assert np.array_equal(a.features, b.features)
    assert np.array_equal(a.leaves, b.leaves)
    assert not np.array_equal(a.features, c.features)


def test_heavier_positives_are_fitted_first() -> None:
    rng = np.random.default_rng(4)
    x = rng.integers(0, 256, (400, 30), dtype=np.uint8)
    x[:200, 5] = 250
    x[200:, 9] = 250
    bad = rng.integers(0, 240, (400, 30), dtype=np.uint8)
    weights = np.where(np.arange(400) < 200, 1.0, 1e-3)
    ensemble = boost(x, bad, BoostingPlan(1, depth=1, feature_share=1.0), rng, 2, weights)
    assert ensemble.features[0, 0] == 5


def test_depth_is_limited_to_that_of_the_paper() -> None:
    with pytest.raises(ValueError, match="depth must be in 1..5. Got 6"):
        BoostingPlan(1, depth=6)


def test_arrays_of_wrong_shape_are_refused() -> None:
    with pytest.raises(ValueError, match="leaves must have shape"):
        TreeEnsemble(
            np.zeros((2, 7), np.int32), np.zeros((2, 7), np.uint8), np.zeros((2, 7), np.int16),
            np.full(2, NEVER, np.int32), 4,
        )  # fmt: skip
    with pytest.raises(ValueError, match="inner nodes. Got 6"):
        TreeEnsemble(
            np.zeros((2, 6), np.int32), np.zeros((2, 6), np.uint8), np.zeros((2, 7), np.int16),
            np.full(2, NEVER, np.int32), 4,
        )  # fmt: skip
