"""Fits the mapping from scores to log-odds of being a sign."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from tsr_engine.records import FloatArray


def fit_calibration(scores: FloatArray, labels: FloatArray, ridge: float = 1e-3) -> FloatArray:
    """Logistic regression ``log-odds = scores @ c[:-1] + c[-1]`` with ``c[:-1] >= 0``.

    scikit-learn's logistic regression cannot keep weights non-negative, and a score that lowers the
    log-odds of a sign would be used against its meaning.

    Args:
        scores: shape (n, k); a higher score means more sign-like.
        labels: shape (n,), +1 sign, -1 not; from scenes that trained none of the scores.
        ridge: strength of the pull of the weights towards 0.

    Returns:
        Shape (k + 1,).
    """
    features = np.concatenate([scores, np.ones((len(scores), 1))], axis=1)

    def loss(c: FloatArray) -> tuple[float, FloatArray]:
        margin = labels * (features @ c)
        value = np.mean(np.logaddexp(0.0, -margin)) + ridge * float(c[:-1] @ c[:-1])
        pull = -labels / (1.0 + np.exp(np.clip(margin, -500, 500)))
        gradient = features.T @ pull / len(labels)
        gradient[:-1] += 2 * ridge * c[:-1]
        return float(value), gradient

    count = scores.shape[1]
    start = np.concatenate([np.full(count, 0.1), [0.0]])
    bounds = [(0.0, None)] * count + [(None, None)]
    return np.asarray(minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds).x)
