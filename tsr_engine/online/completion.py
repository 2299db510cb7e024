"""Completes a dual solution: exact gradient, refinement, and the offset if there are no margin vectors.

The path of :mod:`tsr_engine.online.solution_path` accumulates rounding. After each sample, the gradient is computed
from the coefficients, and the margin equations are refined with it, so that errors do not add up over a track.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.online.margin import DEPENDENT, contract, rebuild
from tsr_engine.online.solution_path import ERROR, RESERVE
from tsr_engine.records import FloatArray

AT_BOUND = 1e-12
"""Distance from a bound, as a share of C, within which an alpha counts as at the bound."""


@njit(cache=True, nogil=True)
def gradient(Q: FloatArray, y: FloatArray, n: int, alpha: FloatArray, b: float, g: FloatArray) -> None:
    """``g_i = sum_j Q_ij alpha_j + y_i b - 1`` for all samples."""
    for i in range(n):
        g[i] = y[i] * b - 1.0
    for j in range(n):
        factor = alpha[j]
        if factor != 0.0:
            for i in range(n):
                g[i] += factor * Q[j, i]


@njit(cache=True, nogil=True)
def violation(y: FloatArray, n: int, C: float, alpha: FloatArray, g: FloatArray) -> float:
    """Largest violation of the KKT conditions: the signs of g, the bounds of alpha, and ``sum y alpha = 0``."""
    worst, balance = 0.0, 0.0
    for i in range(n):
        balance += y[i] * alpha[i]
        if alpha[i] <= 0.0:
            value = max(-g[i], -alpha[i])
        elif alpha[i] >= C:
            value = max(g[i], alpha[i] - C)
        else:
            value = abs(g[i])
        worst = max(worst, value)
    return max(worst, abs(balance))


@njit(cache=True, nogil=True)
def central_offset(y: FloatArray, n: int, g: FloatArray) -> float:
    """The step from the current offset to the middle of its optimal interval, as in libsvm.

    As a function of the offset, the primal is ``C`` times a sum of hinges with kinks at ``-y_i g_i``, relative to the
    current offset. Its slope starts at -C times the number p of positive samples and grows by C at each kink. So the
    minimum lies between kink p and kink p + 1. This holds with and without margin vectors and is continuous in g. If
    all samples have one class, the interval has only one end, which is the result. Without samples the result is 0.
    """
    positive = 0
    kinks = np.empty(n)
    for i in range(n):
        kinks[i] = -y[i] * g[i]
        if y[i] > 0.0:
            positive += 1
    if n == 0:
        return 0.0
    kinks.sort()
    if positive == 0 or positive == n:
        return float(kinks[0] if positive == 0 else kinks[n - 1])
    return float(0.5 * (kinks[positive - 1] + kinks[positive]))


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def refine(
    Q: FloatArray,
    y: FloatArray,
    n: int,
    alpha: FloatArray,
    g: FloatArray,
    b: float,
    S: NDArray[np.int64],
    size: int,
    R: FloatArray,
    residual: FloatArray,
) -> tuple[float, float]:
    """One Newton step on ``g_S = 0, sum y alpha = 0``, and the exact gradient after it.

    Returns:
        The offset and the residual *before* the step.
    """
    balance = 0.0
    for i in range(n):
        balance += y[i] * alpha[i]
    residual[0] = balance
    worst = abs(balance)
    for j in range(size):
        residual[j + 1] = g[S[j]]
        worst = max(worst, abs(g[S[j]]))
    for i in range(size + 1):
        change = 0.0
        for j in range(size + 1):
            change += R[i, j] * residual[j]
        if i == 0:
            b -= change
        else:
            alpha[S[i - 1]] -= change
    gradient(Q, y, n, alpha, b, g)
    return b, worst


@njit(cache=True, nogil=True)
def _leave_bounds(
    C: float, alpha: FloatArray, status: NDArray[np.int8], S: NDArray[np.int64], size: int, R: FloatArray
) -> int:
    """Move margin vectors whose alpha is at a bound to the reserve or error set; returns the new size of S."""
    bound = AT_BOUND * C
    for j in range(size - 1, -1, -1):
        i = S[j]
        if alpha[i] <= bound or alpha[i] >= C - bound:
            alpha[i] = 0.0 if alpha[i] <= bound else C
            status[i] = RESERVE if alpha[i] == 0.0 else ERROR
            contract(R, S, size, j)
            size -= 1
    return size


@njit(cache=True, nogil=True)
def _solve_margin(
    Q: FloatArray,
    y: FloatArray,
    n: int,
    scale: float,
    alpha: FloatArray,
    g: FloatArray,
    b: float,
    S: NDArray[np.int64],
    size: int,
    R: FloatArray,
    beta: FloatArray,
) -> tuple[float, bool]:
    """Refine until the margin equations hold up to rounding; returns False if the members of S are dependent."""
    rebuilt = False
    before = np.inf
    for _ in range(6):
        b, worst = refine(Q, y, n, alpha, g, b, S, size, R, beta)
        if worst <= 1e-12:
            break
        # One step with an exact inverse reduces the residual to rounding; otherwise the inverse has drifted.
        if not rebuilt and (worst > 1e-8 or (worst > 1e-2 * before and worst > 1e-11)):
            rebuilt = True
            if rebuild(R, S, size, Q, y, scale, beta, DEPENDENT) < size:
                return b, False
        before = worst
    return b, True


@njit(cache=True, nogil=True)
def complete(
    Q: FloatArray,
    y: FloatArray,
    n: int,
    C: float,
    scale: float,
    alpha: FloatArray,
    g: FloatArray,
    b: float,
    status: NDArray[np.int8],
    S: NDArray[np.int64],
    size: int,
    R: FloatArray,
    beta: FloatArray,
) -> tuple[float, int, bool]:
    """Compute the exact gradient, refine the margin equations, apply the bounds, and set the offset if S is empty.

    Returns:
        Offset, number of margin vectors, and whether the margin matrix is regular enough for further steps.
    """
    # Each round ends the loop or removes a member from S.
    for _ in range(size + 1):
        size = _leave_bounds(C, alpha, status, S, size, R)
        gradient(Q, y, n, alpha, b, g)
        if size == 0:
            break
        b, regular = _solve_margin(Q, y, n, scale, alpha, g, b, S, size, R, beta)
        if not regular:
            return b, size, False
        free = True
        for j in range(size):
            free = free and AT_BOUND * C < alpha[S[j]] < C - AT_BOUND * C
        if free:
            break
    if size == 0:
        change = central_offset(y, n, g) if n > 0 else -b
        b += change
        for i in range(n):
            g[i] += y[i] * change
    return b, size, True
