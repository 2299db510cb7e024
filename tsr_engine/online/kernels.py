"""Kernel rows for the incremental SVM: one sample against all stored ones.

Sums run in a fixed order inside compiled loops, so a row does not depend on the number of threads.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tsr_engine.linear_algebra import product
from tsr_engine.records import FloatArray

LINEAR = 0
RBF = 1


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def kernel_row(X: FloatArray, n: int, x: FloatArray, kind: int, gamma: float, out: FloatArray) -> None:
    """Kernel values of ``x`` with the first ``n`` rows of ``X``.

    Args:
        X: shape (>= n, d).
        n: number of rows to use.
        x: shape (d,).
        kind: ``LINEAR`` (``<x, z>``) or ``RBF`` (``exp(-gamma |x - z|^2)``).
        gamma: coefficient of the RBF kernel; unused by the linear one.
        out: shape (>= n,); receives the values.
    """
    d = x.shape[0]
    if kind == LINEAR:
        for i in range(n):
            total = 0.0
            for k in range(d):
                total += X[i, k] * x[k]
            out[i] = total
    else:
        for i in range(n):
            total = 0.0
            for k in range(d):
                difference = X[i, k] - x[k]
                total += difference * difference
            out[i] = math.exp(-gamma * total)


def signed_kernel(X: FloatArray, y: FloatArray, kind: int, gamma: float) -> FloatArray:
    """``y_i y_j K(x_i, x_j)`` of all samples, computed without :func:`kernel_row`, for checks of its sums.

    Args:
        X: shape (n, d).
        y: shape (n,), -1 or 1.
        kind: ``LINEAR`` or ``RBF``.
        gamma: coefficient of the RBF kernel; unused by the linear one.

    Returns:
        Shape (n, n).
    """
    if kind == LINEAR:
        return np.asarray(product(X, X.T) * np.outer(y, y))
    squares = np.empty((len(X), len(X)))
    with np.errstate(over="ignore"):  # an overflowing distance gives the kernel value 0
        for i in range(len(X)):
            squares[i] = ((X - X[i]) ** 2).sum(axis=1)
        return np.ascontiguousarray(np.exp(-gamma * squares) * np.outer(y, y))
