"""Completes a dual solution: exact gradient, refinement, and the offset if there are no margin vectors.

The path of :mod:`tsr_engine.online.solution_path` accumulates rounding. After each sample, the gradient is computed
from the coefficients, and the margin equations are refined with it, so that errors do not add up over a track.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tsr_engine.online.dual import Dual
from tsr_engine.online.margin import DEPENDENT, contract, rebuild
from tsr_engine.online.solution_path import ERROR, RESERVE, follow_path

AT_BOUND = 1e-12
"""Distance from a bound, as a share of C, within which an alpha counts as at the bound."""
ACCEPTED = 2e-11
"""Largest KKT violation of an exact solution."""


@njit(cache=True, nogil=True)
def gradient(dual: Dual, b: float) -> None:
    """``g_i = sum_j Q_ij alpha_j + y_i b - 1`` for all samples."""
    n, Q, y, g = dual.n, dual.Q, dual.y, dual.g
    for i in range(n):
        g[i] = y[i] * b - 1.0
    for j in range(n):
        factor = dual.alpha[j]
        if factor != 0.0:
            for i in range(n):
                g[i] += factor * Q[j, i]


@njit(cache=True, nogil=True)
def violation(dual: Dual) -> float:
    """Largest violation of the KKT conditions: the signs of g, the bounds of alpha, and ``sum y alpha = 0``."""
    C, alpha, g = dual.C, dual.alpha, dual.g
    worst, balance = 0.0, 0.0
    for i in range(dual.n):
        balance += dual.y[i] * alpha[i]
        if alpha[i] <= 0.0:
            value = max(-g[i], -alpha[i])
        elif alpha[i] >= C:
            value = max(g[i], alpha[i] - C)
        else:
            value = abs(g[i])
        worst = max(worst, value)
    return max(worst, abs(balance))


@njit(cache=True, nogil=True)
def central_offset(dual: Dual) -> float:
    """The step from the current offset to the middle of its optimal interval, as in libsvm.

    As a function of the offset, the primal is ``C`` times a sum of hinges with kinks at ``-y_i g_i``, relative to the
    current offset. Its slope starts at -C times the number p of positive samples and grows by C at each kink. So the
    minimum lies between kink p and kink p + 1. This holds with and without margin vectors and is continuous in g. If
    all samples have one class, the interval has only one end, which is the result. Without samples the result is 0.
    """
    n, y = dual.n, dual.y
    positive = 0
    kinks = np.empty(n)
    for i in range(n):
        kinks[i] = -y[i] * dual.g[i]
        if y[i] > 0.0:
            positive += 1
    if n == 0:
        return 0.0
    kinks.sort()
    if positive == 0 or positive == n:
        return float(kinks[0] if positive == 0 else kinks[n - 1])
    return float(0.5 * (kinks[positive - 1] + kinks[positive]))


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def refine(dual: Dual, b: float, size: int) -> tuple[float, float]:
    """One Newton step on ``g_S = 0, sum y alpha = 0``, and the exact gradient after it.

    Returns:
        The offset and the residual *before* the step.
    """
    alpha, g, S, residual = dual.alpha, dual.g, dual.S, dual.beta
    balance = 0.0
    for i in range(dual.n):
        balance += dual.y[i] * alpha[i]
    residual[0] = balance
    worst = abs(balance)
    for j in range(size):
        residual[j + 1] = g[S[j]]
        worst = max(worst, abs(g[S[j]]))
    for i in range(size + 1):
        change = 0.0
        for j in range(size + 1):
            change += dual.R[i, j] * residual[j]
        if i == 0:
            b -= change
        else:
            alpha[S[i - 1]] -= change
    gradient(dual, b)
    return b, worst


@njit(cache=True, nogil=True)
def leave_bounds(dual: Dual, size: int) -> int:
    """Move margin vectors whose alpha is at a bound to the reserve or error set; returns the new size of S."""
    C, alpha = dual.C, dual.alpha
    bound = AT_BOUND * C
    for j in range(size - 1, -1, -1):
        i = dual.S[j]
        if alpha[i] <= bound or alpha[i] >= C - bound:
            alpha[i] = 0.0 if alpha[i] <= bound else C
            dual.status[i] = RESERVE if alpha[i] == 0.0 else ERROR
            contract(dual.R, dual.S, size, j)
            size -= 1
    return size


@njit(cache=True, nogil=True)
def _solve_margin(dual: Dual, b: float, size: int) -> tuple[float, bool]:
    """Refine until the margin equations hold up to rounding; returns False if the members of S are dependent."""
    rebuilt = False
    before = np.inf
    for _ in range(6):
        b, worst = refine(dual, b, size)
        if worst <= 1e-12:
            break
        # One step with an exact inverse reduces the residual to rounding; otherwise the inverse has drifted.
        if not rebuilt and (worst > 1e-8 or (worst > 1e-2 * before and worst > 1e-11)):
            rebuilt = True
            if rebuild(dual, size, DEPENDENT) < size:
                return b, False
        before = worst
    return b, True


@njit(cache=True, nogil=True)
def complete(dual: Dual, b: float, size: int) -> tuple[float, int, bool]:
    """Compute the exact gradient, refine the margin equations, apply the bounds, and set the offset if S is empty.

    Returns:
        Offset, number of margin vectors, and whether the solution is exact.
    """
    bound = AT_BOUND * dual.C
    # Each round ends the loop or removes a member from S.
    for _ in range(size + 1):
        size = leave_bounds(dual, size)
        gradient(dual, b)
        if size == 0:
            break
        b, regular = _solve_margin(dual, b, size)
        if not regular:
            return b, size, False
        free = True
        for j in range(size):
            free = free and bound < dual.alpha[dual.S[j]] < dual.C - bound
        if free:
            break
    if size == 0:
        change = central_offset(dual) if dual.n > 0 else -b
        b += change
        for i in range(dual.n):
            dual.g[i] += dual.y[i] * change
    return b, size, violation(dual) <= ACCEPTED


@njit(cache=True, nogil=True)
def add_sample(dual: Dual, b: float, size: int, c: int) -> tuple[float, int, bool]:
    """Learn sample ``c``, whose alpha is 0.

    Returns:
        Offset, number of margin vectors, and whether the solution is exact.
    """
    b, size, reached = follow_path(dual, b, size, c, True)
    if reached:
        b, size, reached = complete(dual, b, size)
    return b, size, reached
