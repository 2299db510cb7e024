"""The ridge regression of the refinements solves the normal equations."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.training.public.refine_stage import ridge


@pytest.mark.parametrize("strength", [3e-3, 1.0])
def test_it_solves_the_normal_equations(strength: float) -> None:
    rng = np.random.default_rng(0)
    features = rng.integers(0, 256, (300, 40), dtype=np.uint8)
    wanted = (features[:, :4] / 255 - 0.5) * [0.2, 0.1, 0.3, 0.4] + rng.normal(0, 0.05, (300, 4))
    weights, bias = ridge(features, wanted, strength)
    x = features / 255
    x, y = x - x.mean(axis=0), wanted - wanted.mean(axis=0)
    exact = np.linalg.solve(x.T @ x + strength * len(x) * np.eye(40), x.T @ y)
    assert weights.dtype == bias.dtype == np.float32
    np.testing.assert_allclose(weights, exact, atol=1e-5)
    np.testing.assert_allclose(bias, wanted.mean(axis=0) - (features / 255).mean(axis=0) @ exact, atol=1e-5)
