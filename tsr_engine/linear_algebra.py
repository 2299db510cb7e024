"""Matrix products and linear systems whose bits depend only on their operands.

The order of sums in a BLAS depends on the number of threads, the processor and the release. A replay must give the same
bits as the run, so all code between pixels and records multiplies with these functions.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.records import FloatArray

# These kernels must not reorder sums (fastmath) or fuse a product with a sum.


@njit(cache=True, nogil=True)
def product(a: NDArray[np.generic], b: NDArray[np.generic]) -> NDArray[np.generic]:
    """``a @ b``; every sum runs from its first term to its last.

    Args:
        a: shape (n, k).
        b: shape (k, m), of the same type; fastest if its rows are contiguous.

    Returns:
        Shape (n, m), of the type of ``a``; sums use this type as well. A row does not depend on the other rows.
    """
    n, length = a.shape
    columns = b.shape[1]
    out = np.zeros((n, columns), a.dtype)
    unrolled = length - length % 4
    # Each pass adds four terms, so that sums are loaded and stored less often. Rows of b stay cached for all of a.
    for k in range(0, unrolled, 4):
        b0, b1, b2, b3 = b[k], b[k + 1], b[k + 2], b[k + 3]
        for i in range(n):
            row = out[i]
            a0, a1, a2, a3 = a[i, k], a[i, k + 1], a[i, k + 2], a[i, k + 3]
            for j in range(columns):
                row[j] = row[j] + a0 * b0[j] + a1 * b1[j] + a2 * b2[j] + a3 * b3[j]
    for k in range(unrolled, length):
        b_row = b[k]
        for i in range(n):
            row, value = out[i], a[i, k]
            for j in range(columns):
                row[j] += value * b_row[j]
    return out


@njit(cache=True, nogil=True)
def dot(a: FloatArray, b: FloatArray) -> float:
    """``a @ b`` of two vectors (n,); the sum runs from its first term to its last."""
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total


@njit(cache=True, nogil=True)
def solve(a: FloatArray, b: FloatArray) -> FloatArray:
    """Solve ``a @ x = b`` by elimination with row pivots; meant for a handful of unknowns.

    Args:
        a: shape (n, n).
        b: shape (n, m).

    Returns:
        Shape (n, m).

    Raises:
        LinAlgError: the matrix is singular.
    """
    n = len(a)
    left, x = a.copy(), b.copy()
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(left[i, k]) > abs(left[pivot, k]):
                pivot = i
        if left[pivot, k] == 0.0:
            raise np.linalg.LinAlgError("The matrix of a linear system is singular.")
        for j in range(n):
            left[k, j], left[pivot, j] = left[pivot, j], left[k, j]
        for j in range(x.shape[1]):
            x[k, j], x[pivot, j] = x[pivot, j], x[k, j]
        for i in range(k + 1, n):
            factor = left[i, k] / left[k, k]
            for j in range(k + 1, n):
                left[i, j] -= factor * left[k, j]
            for j in range(x.shape[1]):
                x[i, j] -= factor * x[k, j]
    for k in range(n - 1, -1, -1):
        for j in range(x.shape[1]):
            total = x[k, j]
            for i in range(k + 1, n):
                total -= left[k, i] * x[i, j]
            x[k, j] = total / left[k, k]
    return x
