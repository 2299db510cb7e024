"""Adds one sample to the dual solution, or removes it, along the path on which all others stay optimal.

Notation of Cauwenberghs & Poggio (2000): ``Q_ij = y_i y_j K_ij``, ``g_i = sum_j Q_ij alpha_j + y_i b - 1``. At the
optimum of the C-SVC dual, every sample belongs to the

* **reserve** set R: ``alpha = 0``, ``g >= 0``;
* **margin** set S: ``0 <= alpha <= C``, ``g = 0``;
* **error** set E: ``alpha = C``, ``g <= 0``;

and ``sum_j y_j alpha_j = 0``. While the candidate's coefficient moves, the first of six events ends a step:
the candidate's g reaches 0; the candidate's alpha reaches its end; a margin alpha falls to 0; a margin alpha
rises to C; an error g rises to 0; a reserve g falls to 0. With S empty only b may move.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tsr_engine.online.dual import Dual
from tsr_engine.online.margin import DEPENDENT, contract, expand, sensitivity

RESERVE = 0
MARGIN = 1
ERROR = 2
CANDIDATE = 3

FLAT = 1e-10
"""A g whose slope is below this share of the largest kernel diagonal counts as constant along a step."""


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _slopes(dual: Dual, size: int, c: int) -> None:
    """``gamma_i = Q_ic + y_i beta_0 + sum_j Q_i,S_j beta_j``: change of g per change of the candidate's alpha.

    Margin vectors, whose g stays 0, get 0.
    """
    n, Q, y, S, beta, slope = dual.n, dual.Q, dual.y, dual.S, dual.beta, dual.slope
    for i in range(n):
        slope[i] = Q[c, i] + y[i] * beta[0]
    if 2 * size < n:
        for j in range(size):
            row, factor = Q[S[j]], beta[j + 1]
            for i in range(n):
                slope[i] += factor * row[i]
        for j in range(size):
            slope[S[j]] = 0.0
        return
    # Most samples are margin vectors, so rows of the few others take less time than columns of the margin vectors.
    spread = np.zeros(n)
    for j in range(size):
        spread[S[j]] = beta[j + 1]
    for i in range(n):
        if dual.status[i] == MARGIN:
            slope[i] = 0.0
            continue
        row = Q[i]
        total = 0.0
        for k in range(n):
            total += row[k] * spread[k]
        slope[i] += total


@njit(cache=True, nogil=True)
def _shift_offset(dual: Dual, c: int, adding: bool) -> tuple[int, float]:
    """For an empty S: the sample that reaches g = 0 first when b moves (-1: none), and the move of b."""
    y, g, status = dual.y, dual.g, dual.status
    direction = y[c] if adding else -y[c]
    limit, index = np.inf, -1
    if adding and g[c] < 0.0:
        limit, index = -g[c], c
    for i in range(dual.n):
        rising = y[i] * direction > 0.0
        if status[i] == RESERVE and not rising:
            distance = g[i]
        elif status[i] == ERROR and rising:
            distance = -g[i]
        else:
            continue
        if distance < limit:
            limit, index = distance, i
    return index, max(limit, 0.0) * direction


@njit(cache=True, nogil=True)
def follow_path(dual: Dual, b: float, size: int, c: int, adding: bool) -> tuple[float, int, bool]:
    """Raise the candidate's alpha until it is optimal (adding), or lower it to 0 (removing).

    Args:
        dual: the dual and its solution, changed in place.
        b: offset.
        size: number of margin vectors.
        c: the candidate.
        adding: True to add it, False to remove it.

    Returns:
        Offset, number of margin vectors, and whether the end was reached. If not, the state is feasible but
        not optimal.
    """
    n, C, y, alpha, g, status, S = dual.n, dual.C, dual.y, dual.alpha, dual.g, dual.status, dual.S
    beta, slope, blocked = dual.beta, dual.slope, dual.blocked
    sign = 1.0 if adding else -1.0
    flat = FLAT * dual.scale
    status[c] = CANDIDATE
    for i in range(n):
        blocked[i] = False
    for _ in range(100 + 20 * n):
        if adding and g[c] >= 0.0:
            status[c] = RESERVE if alpha[c] <= 0.0 else MARGIN
            break
        if not adding and alpha[c] <= 0.0:
            break
        entering = -1
        if size == 0:
            entering, change = _shift_offset(dual, c, adding)
            if entering < 0:
                return b, size, False
            b += change
            for i in range(n):
                g[i] += y[i] * change
            g[entering] = 0.0
            if entering == c:
                status[c] = RESERVE if alpha[c] <= 0.0 else MARGIN
                break
            expand(dual, size, entering, 1.0)
            status[entering] = MARGIN
            size += 1
            continue
        sensitivity(dual, size, c)
        _slopes(dual, size, c)
        # The six events; those of the candidate come first, so that they win ties.
        step, leaving = (C - alpha[c] if adding else alpha[c]), -1
        finished = True
        if adding and slope[c] > flat and -g[c] / slope[c] <= step:
            step = -g[c] / slope[c]
            entering = c
        for j in range(size):
            rate = sign * beta[j + 1]
            if rate < 0.0:
                distance = alpha[S[j]] / -rate
            elif rate > 0.0:
                distance = (C - alpha[S[j]]) / rate
            else:
                continue
            if distance < step:
                step, leaving, entering, finished = max(distance, 0.0), j, -1, False
        for i in range(n):
            rate = sign * slope[i]
            if status[i] == ERROR and rate > flat:
                distance = -g[i] / rate
            elif status[i] == RESERVE and rate < -flat:
                distance = g[i] / -rate
            else:
                continue
            if distance < step and not blocked[i]:
                step, leaving, entering, finished = max(distance, 0.0), -1, i, False
        for j in range(size):
            alpha[S[j]] += sign * step * beta[j + 1]
        alpha[c] += sign * step
        b += sign * step * beta[0]
        for i in range(n):
            g[i] += sign * step * slope[i]
        for j in range(size):
            g[S[j]] = 0.0
        if leaving >= 0:
            index = S[leaving]
            at_zero = sign * beta[leaving + 1] < 0.0
            alpha[index] = 0.0 if at_zero else C
            status[index] = RESERVE if at_zero else ERROR
            contract(dual.R, S, size, leaving)
            size -= 1
            for i in range(n):
                blocked[i] = False
        elif finished:
            if entering == c:
                g[c] = 0.0
                status[c] = MARGIN
            else:
                alpha[c] = C if adding else 0.0
                status[c] = ERROR if adding else RESERVE
            break
        else:
            g[entering] = 0.0
            schur = sensitivity(dual, size, entering)
            if schur > DEPENDENT * dual.scale:
                expand(dual, size, entering, schur)
                status[entering] = MARGIN
                size += 1
            else:
                blocked[entering] = True
    else:
        return b, size, False
    if status[c] == MARGIN:
        if size > 0:
            schur = sensitivity(dual, size, c)
            if schur <= DEPENDENT * dual.scale:
                return b, size, False
        else:
            schur = 1.0
        expand(dual, size, c, schur)
        size += 1
    return b, size, True
