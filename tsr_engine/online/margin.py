"""Maintains the inverse of the bordered margin kernel matrix by rank-one updates.

For margin vectors S the matrix is ``A = [[0, y_S'], [y_S, Q_SS]]`` and its inverse ``R`` gives the sensitivities
``[d b, d alpha_S] = -R [y_c, Q_Sc] d alpha_c`` (Cauwenberghs & Poggio 2000, eq. 8-14). Row and column 0 belong
to the offset b, row and column ``1 + j`` to ``S[j]``.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tsr_engine.online.dual import Dual
from tsr_engine.records import FloatArray

DEPENDENT = 1e-10
"""A sample does not enter S if its Schur complement is below this share of the largest kernel diagonal."""


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def sensitivity(dual: Dual, size: int, c: int) -> float:
    """Compute ``beta = -R [y_c, Q_Sc]``; returns the Schur complement ``Q_cc + [y_c, Q_Sc]' beta`` of sample ``c``."""
    Q, S, R, beta = dual.Q, dual.S, dual.R, dual.beta
    bordered = np.empty(size + 1)
    bordered[0] = dual.y[c]
    for j in range(size):
        bordered[j + 1] = Q[c, S[j]]
    for i in range(size + 1):
        row = R[i]
        total = 0.0
        for j in range(size + 1):
            total += row[j] * bordered[j]
        beta[i] = -total
    schur = float(Q[c, c])
    for j in range(size + 1):
        schur += bordered[j] * beta[j]
    return float(schur)


@njit(cache=True, nogil=True)
def expand(dual: Dual, size: int, c: int, schur: float) -> None:
    """Append ``c`` to the margin vectors; ``beta`` and ``schur`` are those of :func:`sensitivity`."""
    R, beta = dual.R, dual.beta
    if size == 0:
        R[0, 0] = -dual.Q[c, c]
        R[0, 1] = dual.y[c]
        R[1, 0] = dual.y[c]
        R[1, 1] = 0.0
    else:
        last = size + 1
        scale = 1.0 / schur
        for i in range(last):
            factor = beta[i] * scale
            for j in range(last):
                R[i, j] += factor * beta[j]
        for i in range(last):
            R[last, i] = beta[i] * scale
            R[i, last] = R[last, i]
        R[last, last] = scale
    dual.S[size] = c


@njit(cache=True, nogil=True)
def contract(R: FloatArray, S: NDArray[np.int64], size: int, position: int) -> None:
    """Remove the margin vector at ``position``; the last one takes its place."""
    last = size
    k = position + 1
    if size > 1 and not 0.0 < R[k, k] < np.inf:
        # The diagonal is the inverse of a Schur complement, so rounding has destroyed R here. Zeros make the next check
        # of the margin equations fail, which rebuilds R.
        R[:size, :size] = 0.0
    elif size > 1:
        pivot = 1.0 / R[k, k]
        for i in range(last + 1):
            if i == k:
                continue
            factor = R[i, k] * pivot
            # Column k is overwritten below or dropped, so the loop may write to it and needs no branch.
            for j in range(last + 1):
                R[i, j] -= factor * R[k, j]
        if k != last:
            for j in range(last + 1):
                R[k, j] = R[last, j]
            for i in range(last + 1):
                R[i, k] = R[i, last]
            R[k, k] = R[last, last]
    S[position] = S[size - 1]


@njit(cache=True, nogil=True)
def rebuild(dual: Dual, size: int, smallest: float) -> int:
    """Compute R for the members of S from scratch, well-conditioned samples first.

    Args:
        dual: receives the inverse; S is reordered.
        size: number of members.
        smallest: a member depends on the others if its Schur complement is below this share of ``scale``.

    Returns:
        The number of independent members: they are ``S[:result]``; the others depend on them.
    """
    S = dual.S
    if size == 0:
        return 0
    expand(dual, 0, S[0], 1.0)
    done = 1
    for threshold in (1e-4, 1e-7, 1e-10, smallest):
        j = done
        while j < size:
            c = S[j]
            schur = sensitivity(dual, done, c)
            if schur > threshold * dual.scale:
                S[j] = S[done]
                expand(dual, done, c, schur)
                done += 1
            j += 1
    return done
