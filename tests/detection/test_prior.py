import numpy as np
import pytest

from tsr_engine.detection.prior import GRID, SpatialPrior, learn_weight, parzen, with_prior


def test_parzen_peaks_where_signs_are() -> None:
    table = parzen([(0.75, 0.25)] * 3 + [(0.25, 0.5)], 0.05)
    assert table.shape == (GRID, GRID)
    assert table.max() == 1.0
    prior = SpatialPrior(table, 1.0)
    box = lambda x, y: np.array([[200 * x - 5, 100 * y - 5, 200 * x + 5, 100 * y + 5]])  # noqa: E731
    assert prior.at(box(0.75, 0.25), 200, 100)[0] == pytest.approx(1.0, abs=0.02)
    assert prior.at(box(0.25, 0.5), 200, 100)[0] == pytest.approx(1 / 3, abs=0.02)
    assert prior.at(box(0.05, 0.95), 200, 100)[0] < 1e-6


def test_parzen_of_one_point_is_a_gaussian() -> None:
    table = parzen([(0.5, 0.5)], 0.1)
    nodes = (np.arange(GRID) + 0.5) / GRID
    expected = np.exp(-0.5 * ((nodes[None] - 0.5) ** 2 + (nodes[:, None] - 0.5) ** 2) / 0.01)
    np.testing.assert_allclose(table, expected / expected.max(), atol=1e-6)


def test_weight_of_equation_8_by_hand() -> None:
    # H = (0.5, -0.2, -0.9), P = (0.9, 0.5, 0.1), y = (1, 1, -1): q = (0.4, 0, -0.4), y - H = (0.5, 1.2, -0.1)
    # lambda = (0.4 * 0.5 + 0 + 0.4 * 0.1) / (0.16 + 0.16) = 0.24 / 0.32
    assert learn_weight([0.5, -0.2, -0.9], [0.9, 0.5, 0.1], [1, 1, -1]) == pytest.approx(0.75)


def test_weight_minimises_the_loss() -> None:
    rng = np.random.default_rng(0)
    raw, prior = rng.normal(size=200), rng.random(200)
    labels = np.where(raw + 2 * (prior - 0.5) + rng.normal(size=200) * 0.3 > 0, 1.0, -1.0)
    best = learn_weight(raw, prior, labels)
    loss = lambda weight: np.sum((with_prior(raw, prior, weight) - labels) ** 2)  # noqa: E731
    assert best > 0
    assert loss(best) < min(loss(best + 0.01), loss(best - 0.01))


def test_a_misleading_prior_gets_no_weight() -> None:
    assert learn_weight([0.0, 0.0], [1.0, 0.0], [-1, 1]) == 0.0
    assert learn_weight([0.0], [0.5], [1]) == 0.0


def test_equation_2_by_hand() -> None:
    assert with_prior(np.array([1.0, 1.0]), np.array([1.0, 0.25]), 2.0).tolist() == [2.0, 0.5]


def test_empty_and_misshapen_input() -> None:
    with pytest.raises(ValueError, match="at least one centre"):
        parzen([], 0.1)
    with pytest.raises(ValueError, match="table must have shape"):
        SpatialPrior(np.zeros((3, 3), np.float32), 0.0)
