"""Returns to an exact solution when the path fails on a numerically singular margin set.

The first step is sequential minimal optimisation (SMO) with second-order pair selection (Fan, Chen & Lin, JMLR 2005).
It needs no inverse and works with any positive semi-definite kernel. The second step is the active-set method of
:mod:`tsr_engine.online.active_set`, which reaches an exact solution where SMO converges slowly.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tsr_engine.online.active_set import solve_sets
from tsr_engine.online.completion import gradient, violation
from tsr_engine.online.dual import Dual

TOLERANCE = 1e-10
"""Largest violation of a pair at which SMO stops."""
ROUNDS = 3
"""Rounds of SMO and active set; one suffices unless the active set stalls at a degenerate point."""


@njit(cache=True, nogil=True)
def balance(dual: Dual) -> None:
    """Lower coefficients in their order until ``sum y alpha = 0``."""
    n, y, alpha = dual.n, dual.y, dual.alpha
    excess = 0.0
    for i in range(n):
        excess += y[i] * alpha[i]
    for i in range(n):
        if excess * y[i] > 0.0:
            less = min(alpha[i], abs(excess))
            alpha[i] -= less
            excess -= y[i] * less


@njit(cache=True, nogil=True)
def minimise_pairs(dual: Dual, limit: int) -> bool:
    """SMO on the dual from a feasible ``alpha``; ``g`` becomes the gradient for offset 0.

    Returns:
        Whether the largest violation fell below ``TOLERANCE`` within ``limit`` pairs.
    """
    n, C, Q, y, alpha, g = dual.n, dual.C, dual.Q, dual.y, dual.alpha, dual.g
    gradient(dual, 0.0)
    bound = 1e-15 * C
    for _ in range(limit):
        i, highest = -1, -np.inf
        for t in range(n):
            if (alpha[t] < C if y[t] > 0 else alpha[t] > 0.0) and -y[t] * g[t] > highest:
                i, highest = t, -y[t] * g[t]
        j, lowest, gain = -1, np.inf, 0.0
        for t in range(n):
            if alpha[t] > 0.0 if y[t] > 0 else alpha[t] < C:
                value = -y[t] * g[t]
                lowest = min(lowest, value)
                difference = highest - value
                if i >= 0 and difference > 0.0:
                    curvature = max(Q[i, i] + Q[t, t] - 2.0 * y[i] * y[t] * Q[i, t], 1e-12)
                    if difference * difference / curvature > gain:
                        gain = difference * difference / curvature
                        j = t
        if i < 0 or j < 0 or highest - lowest <= TOLERANCE:
            return True
        curvature = max(Q[i, i] + Q[j, j] - 2.0 * y[i] * y[j] * Q[i, j], 1e-12)
        step = (highest + y[j] * g[j]) / curvature
        step = min(step, C - alpha[i] if y[i] > 0 else alpha[i])
        step = min(step, alpha[j] if y[j] > 0 else C - alpha[j])
        for t, change in ((i, y[i] * step), (j, -y[j] * step)):
            old = alpha[t]
            new = old + change
            if new <= bound:
                new = 0.0
            elif new >= C - bound:
                new = C
            alpha[t] = new
            for k in range(n):
                g[k] += (new - old) * Q[t, k]
    return False


@njit(cache=True, nogil=True)
def repair(dual: Dual) -> tuple[float, int]:
    """Solve from the current coefficients, for which ``sum y alpha`` may differ from 0, and rebuild the sets.

    Returns:
        Offset and number of margin vectors.
    """
    b, size = 0.0, 0
    for _ in range(ROUNDS):
        balance(dual)
        minimise_pairs(dual, 20 * dual.n + 2000)
        b, size = solve_sets(dual)
        if violation(dual) <= 1e-11:
            break
    return b, size
