"""An active-set method for the dual: exact sets and coefficients from a nearly optimal start.

As on the path of :mod:`tsr_engine.online.solution_path`, one coefficient moves and the margin vectors follow. Other
samples may violate the optimality conditions meanwhile. Each move lowers the objective, so any feasible start works.
Free coefficients that depend on the margin vectors move to a bound along directions in which the dual is flat. This
leaves an independent margin set.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tsr_engine.online.completion import AT_BOUND, central_offset, gradient, leave_bounds
from tsr_engine.online.dual import Dual
from tsr_engine.online.margin import contract, expand, rebuild, sensitivity
from tsr_engine.online.solution_path import ERROR, MARGIN, RESERVE

SINGULAR = 1e-13
"""A Schur complement below this share of the largest kernel diagonal counts as 0: the direction is flat."""


@njit(cache=True, nogil=True)
def solve_sets(dual: Dual) -> tuple[float, int]:
    """Solve the dual from feasible coefficients, up to rounding; the best coefficients found remain.

    Returns:
        Offset and number of margin vectors.
    """
    n, alpha = dual.n, dual.alpha
    least, best = np.inf, alpha[:n].copy()
    b, size = _initialise_sets(dual)
    for _ in range(100 + 20 * n):
        b, size = _solve_margin(dual, b, size)
        if size == 0:
            b = _centre_offset(dual, b)
        worst, candidate = _worst_violation(dual, size)
        if worst < least:
            least = worst
            best[:] = alpha[:n]
        total = 0.0
        for i in range(n):
            total += alpha[i]
        if candidate < 0 or (worst <= 4e-16 * (1.0 + dual.scale * total) and dual.status[candidate] != MARGIN):
            return b, size
        if size == 0:
            b, candidate = _first_pair(dual, b)
            if candidate < 0:
                break
            size = 1
        b, size = _move(dual, b, size, candidate)
    alpha[:n] = best
    b, size = _initialise_sets(dual)
    if size == 0:
        b = _centre_offset(dual, b)
    return b, size


@njit(cache=True, nogil=True)
def _initialise_sets(dual: Dual) -> tuple[float, int]:
    """Set up sets, inverse and gradient from the coefficients; returns the offset and the size of S."""
    n, C, y, alpha, g, status, S = dual.n, dual.C, dual.y, dual.alpha, dual.g, dual.status, dual.S
    free = 0
    for i in range(n):
        if alpha[i] <= AT_BOUND * C:
            alpha[i], status[i] = 0.0, RESERVE
        elif alpha[i] >= C - AT_BOUND * C:
            alpha[i], status[i] = C, ERROR
        else:
            status[i] = MARGIN
            S[free] = i
            free += 1
    gradient(dual, 0.0)
    b = 0.0
    for j in range(free):
        b -= y[S[j]] * g[S[j]] / free
    for i in range(n):
        g[i] += y[i] * b
    return b, rebuild(dual, free, SINGULAR)


@njit(cache=True, nogil=True)
def _centre_offset(dual: Dual, b: float) -> float:
    """The offset in the middle of its optimal interval; updates ``g``."""
    change = central_offset(dual)
    for i in range(dual.n):
        dual.g[i] += dual.y[i] * change
    return float(b + change)


@njit(cache=True, nogil=True)
def _worst_violation(dual: Dual, size: int) -> tuple[float, int]:
    """The largest violation, and the sample to move: a free one outside S, else the worst one; -1: none."""
    n, g, status, S = dual.n, dual.g, dual.status, dual.S
    inside = np.zeros(n, dtype=np.bool_)
    worst, balance = 0.0, 0.0
    for j in range(size):
        inside[S[j]] = True
        worst = max(worst, abs(g[S[j]]))
    candidate, outside, largest = -1, -1, 0.0
    for i in range(n):
        balance += dual.y[i] * dual.alpha[i]
        if inside[i]:
            continue
        if status[i] == MARGIN:
            value = abs(g[i])
            outside = i
        else:
            value = -g[i] if status[i] == RESERVE else g[i]
        if value > largest:
            candidate, largest = i, value
    return max(worst, largest, abs(balance)), outside if outside >= 0 else candidate


@njit(cache=True, nogil=True)
def _first_pair(dual: Dual, b: float) -> tuple[float, int]:
    """Choose the most violating pair for an empty S, since no coefficient can move alone; the first becomes S.

    Returns:
        The offset at which g of the first is 0, and the second sample, which is to move; -1 without a violating pair.
    """
    n, C, y, alpha, g = dual.n, dual.C, dual.y, dual.alpha, dual.g
    i, j, highest, lowest = -1, -1, -np.inf, np.inf
    for t in range(n):
        value = -y[t] * g[t]
        if (alpha[t] < C if y[t] > 0 else alpha[t] > 0.0) and value > highest:
            i, highest = t, value
        if (alpha[t] > 0.0 if y[t] > 0 else alpha[t] < C) and value < lowest:
            j, lowest = t, value
    if i < 0 or j < 0 or highest <= lowest:
        return b, -1
    for t in range(n):
        g[t] += y[t] * lowest
    g[j] = 0.0
    expand(dual, 0, j, 1.0)
    dual.status[j] = MARGIN
    return b + lowest, i


@njit(cache=True, nogil=True)
def _move(dual: Dual, b: float, size: int, c: int) -> tuple[float, int]:
    """Move one coefficient downhill until its g is 0, it is at a bound, or S is empty; updates only ``g[c]``.

    Returns:
        Offset and size of S.
    """
    C, alpha, g, status, S, beta = dual.C, dual.alpha, dual.g, dual.status, dual.S, dual.beta
    sign = -1.0 if g[c] > 0.0 or (g[c] == 0.0 and status[c] != RESERVE) else 1.0
    while size > 0:
        schur = sensitivity(dual, size, c)
        step, leaving, arrives = (C - alpha[c] if sign > 0.0 else alpha[c]), -1, False
        if schur > SINGULAR * dual.scale:
            distance = max(-sign * g[c], 0.0) / schur
            if distance <= step:
                step, arrives = distance, True
        for j in range(size):
            rate = sign * beta[j + 1]
            if rate < 0.0:
                distance = alpha[S[j]] / -rate
            elif rate > 0.0:
                distance = (C - alpha[S[j]]) / rate
            else:
                continue
            if distance < step:
                step, leaving, arrives = max(distance, 0.0), j, False
        for j in range(size):
            alpha[S[j]] = min(max(alpha[S[j]] + sign * step * beta[j + 1], 0.0), C)
        alpha[c] = min(max(alpha[c] + sign * step, 0.0), C)
        b += sign * step * beta[0]
        g[c] += sign * step * schur
        if leaving >= 0:
            index = S[leaving]
            at_zero = sign * beta[leaving + 1] < 0.0
            alpha[index] = 0.0 if at_zero else C
            status[index] = RESERVE if at_zero else ERROR
            contract(dual.R, S, size, leaving)
            size -= 1
            continue
        if arrives and 0.0 < alpha[c] < C:
            expand(dual, size, c, schur)
            status[c] = MARGIN
            size += 1
            break
        status[c] = RESERVE if alpha[c] <= 0.0 else ERROR if alpha[c] >= C else MARGIN
        break
    else:
        status[c] = RESERVE if alpha[c] <= 0.0 else ERROR if alpha[c] >= C else MARGIN
        if status[c] == MARGIN:
            expand(dual, 0, c, 1.0)
            size = 1
    return b, size


@njit(cache=True, nogil=True)
def _solve_margin(dual: Dual, b: float, size: int) -> tuple[float, int]:
    """Newton steps on the margin equations, each shortened at the first bound; members at a bound leave S.

    Returns:
        Offset and size of S; ``g`` is exact for these values.
    """
    C, alpha, g, S = dual.C, dual.alpha, dual.g, dual.S
    residual = np.empty(size + 1)
    change = np.empty(size + 1)
    rebuilt = False
    before = np.inf
    for _ in range(size + 12):
        free = leave_bounds(dual, size)
        if free < size:
            size, before = free, np.inf
        gradient(dual, b)
        if size == 0:
            break
        residual[0] = 0.0
        for i in range(dual.n):
            residual[0] += dual.y[i] * alpha[i]
        worst = abs(residual[0])
        for j in range(size):
            residual[j + 1] = g[S[j]]
            worst = max(worst, abs(g[S[j]]))
        if worst == 0.0 or (rebuilt and worst > 0.5 * before):
            break
        if worst > 0.1 * before:
            if worst < 1e-13:
                break
            rebuilt = True
            size = rebuild(dual, size, SINGULAR)
            before = np.inf
            continue
        before = worst
        for i in range(size + 1):
            total = 0.0
            for j in range(size + 1):
                total -= dual.R[i, j] * residual[j]
            change[i] = total
        share = 1.0
        for j in range(size):
            reached = alpha[S[j]] + change[j + 1]
            if reached < 0.0:
                share = min(share, alpha[S[j]] / -change[j + 1])
            elif reached > C:
                share = min(share, (C - alpha[S[j]]) / change[j + 1])
        b += share * change[0]
        for j in range(size):
            alpha[S[j]] = min(max(alpha[S[j]] + share * change[j + 1], 0.0), C)
    return b, size
