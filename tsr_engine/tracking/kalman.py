"""The two covariance steps of a Kalman filter, shared by all motion models."""

from __future__ import annotations

import numpy as np
from numba import njit

from tsr_engine.linear_algebra import product, solve
from tsr_engine.records import FloatArray


@njit(cache=True, nogil=True)
def propagate_covariance(P: FloatArray, F: FloatArray) -> FloatArray:
    """``F P F'``: covariance (n, n) after a linear step with matrix F, shape (n, n)."""
    after: FloatArray = product(product(F, P), F.T)
    return after


@njit(cache=True, nogil=True)
def update_covariance(P: FloatArray, H: FloatArray, R: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gain and covariance of a measurement update, Joseph form.

    Args:
        P: covariance of the state, shape (n, n).
        H: measurement matrix, shape (m, n).
        R: covariance of the measurement, shape (m, m).

    Returns:
        The gain K, shape (n, m), by which the innovation moves the mean; and the new covariance, shape (n, n).
    """
    projected = product(H, P)
    K = np.ascontiguousarray(solve(product(projected, H.T) + R, projected).T)
    remaining = np.eye(len(P)) - product(K, H)
    return K, propagate_covariance(P, remaining) + propagate_covariance(R, K)
