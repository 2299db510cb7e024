"""The two covariance steps of a Kalman filter, shared by all motion models."""

from __future__ import annotations

import numpy as np
from numba import njit

from tsr_engine.products import product, solve
from tsr_engine.records import FloatArray

__all__ = ["correct", "spread"]


@njit(cache=True, nogil=True)
def spread(P: FloatArray, F: FloatArray) -> FloatArray:
    """``F P F'``: covariance (n, n) after a step that is linear with F, shape (n, n)."""
    after: FloatArray = product(product(F, P), F.T)
    return after


@njit(cache=True, nogil=True)
def correct(P: FloatArray, H: FloatArray, R: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gain and covariance of a measurement update, Joseph form.

    Args:
        P: covariance of the state, shape (n, n).
        H: what is measured of the state, shape (m, n).
        R: covariance of the measurement, shape (m, m).

    Returns:
        The gain K, shape (n, m): the mean moves by K times the innovation; and the covariance after it.
    """
    seen = product(H, P)
    K = np.ascontiguousarray(solve(product(seen, H.T) + R, seen).T)
    rest = np.eye(len(P)) - product(K, H)
    return K, spread(P, rest) + spread(R, K)
