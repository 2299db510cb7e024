"""From two scores to log-odds of being a sign."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from tsr_engine.records import FloatArray


def fit_calibration(
    verified: FloatArray, cascade: FloatArray, labels: FloatArray, ridge: float = 1e-3
) -> tuple[float, float, float]:
    """Logistic regression ``log-odds = c0 * verified + c1 * cascade + c2`` with ``c0, c1 >= 0``.

    Args:
        verified: shape (n,), scores of the second look.
        cascade: shape (n,), scores of the cascade.
        labels: shape (n,), +1 sign, -1 not; taken from scenes that trained neither.
        ridge: pull of c0 and c1 towards 0.

    Returns:
        ``c0, c1, c2``.
    """
    features = np.stack([verified, cascade, np.ones_like(verified)], axis=1)

    def loss(c: FloatArray) -> tuple[float, FloatArray]:
        margin = labels * (features @ c)
        value = np.mean(np.logaddexp(0.0, -margin)) + ridge * float(c[:2] @ c[:2])
        pull = -labels / (1.0 + np.exp(np.clip(margin, -500, 500)))
        gradient = features.T @ pull / len(labels)
        gradient[:2] += 2 * ridge * c[:2]
        return float(value), gradient

    result = minimize(
        loss, np.array([0.1, 0.1, 0.0]), jac=True, method="L-BFGS-B", bounds=[(0, None), (0, None), (None, None)]
    )
    c0, c1, c2 = (float(v) for v in result.x)
    return c0, c1, c2
