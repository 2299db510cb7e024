"""The way back to an exact solution where the path fails: numerically singular margin sets.

Sequential minimal optimisation with second-order pair selection (Fan, Chen & Lin, JMLR 2005) needs no inverse and
makes progress with any positive semi-definite kernel; starting next to the optimum it needs few pairs.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.online.margin import DEPENDENT, contract, expand, rebuild, sensitivity
from tsr_engine.online.path import ERROR, MARGIN, RESERVE
from tsr_engine.online.settle import central_offset, gradient, offset_interval, violation
from tsr_engine.records import FloatArray

TOLERANCE = 1e-10
"""Half the largest violation of a pair at which the repair stops."""


@njit(cache=True, nogil=True)
def minimise_pairs(
    Q: FloatArray, y: FloatArray, n: int, C: float, alpha: FloatArray, g: FloatArray, limit: int
) -> bool:
    """SMO on the dual from a feasible ``alpha``; ``g`` is kept with offset 0.

    Returns:
        Whether the largest violation fell below ``2 * TOLERANCE`` within ``limit`` pairs.
    """
    gradient(Q, y, n, alpha, 0.0, g)
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
def _purify(
    Q: FloatArray,
    y: FloatArray,
    C: float,
    scale: float,
    alpha: FloatArray,
    b: float,
    status: NDArray[np.int8],
    S: NDArray[np.int64],
    size: int,
    free: int,
    R: FloatArray,
    beta: FloatArray,
) -> tuple[float, int]:
    """Bring free coefficients that depend on S to a bound, along directions in which the dual is flat.

    Args:
        Q: signed kernel matrix.
        y: labels.
        C: upper bound of alpha.
        scale: largest kernel diagonal.
        alpha: coefficients, changed in place.
        b: offset.
        status: sets, changed in place.
        S: ``S[:size]`` are independent margin vectors, ``S[size:free]`` depend on them. Changed in place.
        size: number of independent margin vectors.
        free: number of free coefficients.
        R: inverse for ``S[:size]``, changed in place.
        beta: scratch.

    Returns:
        Offset and number of margin vectors.
    """
    waiting = S[size:free].copy()
    for i in waiting:
        while True:
            schur = sensitivity(R, S, size, Q, y, i, beta)
            if schur > DEPENDENT * scale:
                expand(R, S, size, Q, y, i, beta, schur)
                size += 1
                break
            step, leaving = alpha[i], -1
            for j in range(size):
                if beta[j + 1] > 0.0:
                    distance = alpha[S[j]] / beta[j + 1]
                elif beta[j + 1] < 0.0:
                    distance = (alpha[S[j]] - C) / beta[j + 1]
                else:
                    continue
                if distance < step:
                    step, leaving = max(distance, 0.0), j
            for j in range(size):
                alpha[S[j]] = min(max(alpha[S[j]] - step * beta[j + 1], 0.0), C)
            b -= step * beta[0]
            alpha[i] -= step
            if leaving < 0:
                alpha[i] = 0.0
                status[i] = RESERVE
                break
            index = S[leaving]
            at_zero = beta[leaving + 1] > 0.0
            alpha[index] = 0.0 if at_zero else C
            status[index] = RESERVE if at_zero else ERROR
            contract(R, S, size, leaving)
            size -= 1
            if size == 0:
                expand(R, S, 0, Q, y, i, beta, 1.0)
                size = 1
                break
    return b, size


@njit(cache=True, nogil=True)
def repair(
    Q: FloatArray,
    y: FloatArray,
    n: int,
    C: float,
    scale: float,
    alpha: FloatArray,
    g: FloatArray,
    status: NDArray[np.int8],
    S: NDArray[np.int64],
    R: FloatArray,
    beta: FloatArray,
) -> tuple[float, int]:
    """Solve again from the present coefficients and rebuild the sets.

    Returns:
        Offset and number of margin vectors.
    """
    minimise_pairs(Q, y, n, C, alpha, g, 200 * n + 20000)
    solved = alpha[:n].copy()
    b, size, free = _regroup(Q, y, n, C, scale, alpha, g, status, S, R, beta)
    if free > size:
        b, size = _purify(Q, y, C, scale, alpha, b, status, S, size, free, R, beta)
        gradient(Q, y, n, alpha, b, g)
        if violation(y, n, C, alpha, g) > 1e-9:
            # The dependence is not exact. Keep the optimum: what is free outside S stands still until a later repair.
            alpha[:n] = solved
            gradient(Q, y, n, alpha, 0.0, g)
            b, size, free = _regroup(Q, y, n, C, scale, alpha, g, status, S, R, beta)
    gradient(Q, y, n, alpha, b, g)
    return b, size


@njit(cache=True, nogil=True)
def _regroup(
    Q: FloatArray,
    y: FloatArray,
    n: int,
    C: float,
    scale: float,
    alpha: FloatArray,
    g: FloatArray,
    status: NDArray[np.int8],
    S: NDArray[np.int64],
    R: FloatArray,
    beta: FloatArray,
) -> tuple[float, int, int]:
    """Sets, inverse and offset from coefficients alone; ``g`` must hold the gradient for offset 0.

    Returns:
        Offset, number of independent free coefficients (S), number of free coefficients.
    """
    free = 0
    for i in range(n):
        if alpha[i] <= 0.0:
            status[i] = RESERVE
        elif alpha[i] >= C:
            status[i] = ERROR
        else:
            status[i] = MARGIN
            S[free] = i
            free += 1
    if free == 0:
        low, high = offset_interval(y, n, C, alpha, g, 0.0)
        return central_offset(low, high), 0, 0
    b = 0.0
    for j in range(free):
        b -= y[S[j]] * g[S[j]]
    return b / free, rebuild(R, S, free, Q, y, scale, beta), free
