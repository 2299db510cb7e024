"""Kernel rows for the incremental SVM: one sample against all stored ones.

Sums run in a fixed order inside compiled loops, so a row does not depend on the number of threads.
"""

from __future__ import annotations

import math

from numba import njit

from tsr_engine.records import FloatArray

LINEAR = 0
RBF = 1


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def kernel_row(X: FloatArray, n: int, x: FloatArray, kind: int, gamma: float, out: FloatArray) -> None:
    """Kernel values of ``x`` with the first ``n`` rows of ``X``.

    Args:
        X: shape (>= n, d).
        n: rows that count.
        x: shape (d,).
        kind: ``LINEAR`` (``<x, z>``) or ``RBF`` (``exp(-gamma |x - z|^2)``).
        gamma: width of the RBF kernel, ignored for the linear one.
        out: shape (>= n,), receives the values.
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
