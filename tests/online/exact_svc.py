"""An oracle for batch C-SVC: an interior-point method in extended precision that certifies its own error.

It shares nothing with the incremental solver: no active sets, no updates, its own kernel. libsvm cannot serve as
the oracle to 1e-6, since it keeps its kernel matrix in single precision.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = np.longdouble
Array = NDArray[Any]
EXTENDED = bool(np.finfo(Real).eps < 1e-18)
"""Whether this machine has more than double precision; without it the certificate is weaker."""


class ExactSVC:
    """The batch solution on samples X, y.

    Attributes:
        gap: duality gap; ``|f(x) - f*(x)| <= 2 sqrt(2 gap max K)`` wherever K(x, x) is at most the samples'.
    """

    def __init__(self, X: Array, y: Array, C: float, kernel: str, gamma: float) -> None:
        self.X, self.y, self.kind, self.gamma = X, y.astype(Real), kernel, Real(gamma)
        K = self.kernel(X)
        Q = K * np.outer(self.y, self.y)
        with np.errstate(all="ignore"):  # the last step may be too short to divide by
            inside, free = _interior_point(Q, self.y, Real(C))
        self.alpha = _polished(Q, self.y, Real(C), inside, free)
        h = K @ (self.alpha * self.y)
        self.b = centre(h, self.y)
        quadratic = self.alpha @ Q @ self.alpha
        hinge = np.maximum(0, 1 - self.y * (h + self.b)).sum()
        self.objective = float(self.alpha.sum() - quadratic / 2)
        self.gap = float(quadratic + Real(C) * hinge - self.alpha.sum())

    def kernel(self, points: Array) -> Array:
        """K between points and the samples, in extended precision."""
        Z, X = np.asarray(points, dtype=Real), np.asarray(self.X, dtype=Real)
        if self.kind == "linear":
            return np.asarray((Z[:, None] * X[None]).sum(axis=2))
        return np.asarray(np.exp(-self.gamma * ((Z[:, None] - X[None]) ** 2).sum(axis=2)))

    def decision_function(self, points: Array) -> Array:
        """Decision values, float64."""
        return np.asarray(self.kernel(points) @ (self.alpha * self.y) + self.b, dtype=np.float64)


def centre(h: Array, y: Array) -> Any:
    """The midpoint of the offsets that minimise the sum of hinges of ``y (h + b)``."""
    kinks, positive = np.sort(y - h), int((y > 0).sum())
    return (kinks[positive - 1] + kinks[positive]) / 2


def _interior_point(Q: Array, y: Array, C: Any) -> tuple[Array, Array]:
    """Mehrotra's method on ``min a'Qa/2 - 1'a, y'a = 0, 0 <= a <= C``: the best iterate and its free coefficients."""
    n, zeros = len(y), np.zeros(len(y), dtype=Real)
    total = C / 2 * min((y > 0).sum(), (y < 0).sum())
    a = np.where(y > 0, total / (y > 0).sum(), total / (y < 0).sum())
    b = Real(0)
    low = np.maximum(np.abs(Q @ a - 1), 1)
    high = low.copy()
    best, free, least, stalled = a, a > 0, Real(np.inf), 0
    for _ in range(100):
        room = C - a
        dual, primal = Q @ a - 1 + y * b - low + high, y @ a
        gap = a @ low + room @ high
        error = gap + C * max(np.abs(dual).max(), abs(primal))
        stalled += 1
        if error < least:
            best, free, least, stalled = a, (a > C * low) & (room > C * high), error, 0
        if stalled > 3 or gap < 1e-22 * max(1, C) or min(a.min(), room.min(), low.min(), high.min()) <= 0:
            break

        def direction(at_low: Array, at_high: Array) -> tuple[Array, Any, Array, Array]:
            right = -dual + (at_low / a - low) - (at_high / room - high)  # noqa: B023
            solved = _solve(Q + np.diag(low / a + high / room), np.stack([right, y], axis=1))  # noqa: B023
            db = (y @ solved[:, 0] + primal) / (y @ solved[:, 1])  # noqa: B023
            da = solved[:, 0] - db * solved[:, 1]
            return da, db, at_low / a - low - low / a * da, at_high / room - high + high / room * da  # noqa: B023

        da, db, dl, dh = direction(zeros, zeros)
        t = min(_reach(v, d) for v, d in ((a, da), (room, -da), (low, dl), (high, dh)))
        mean = gap / (2 * n)
        after = ((a + t * da) @ (low + t * dl) + (room - t * da) @ (high + t * dh)) / (2 * n)
        aim = (after / mean) ** 3 * mean
        da, db, dl, dh = direction(aim - da * dl, aim + da * dh)
        t = Real("0.995") * min(_reach(v, d) for v, d in ((a, da), (room, -da), (low, dl), (high, dh)))
        a, b, low, high = a + t * da, b + t * db, low + t * dl, high + t * dh
    return best, free


def _polished(Q: Array, y: Array, C: Any, inside: Array, free: Array) -> Array:
    """Set bounded coefficients to their bounds and solve the margin equations, if that improves the solution."""
    a = np.where(free, inside, np.where(inside > C / 2, C, Real(0)))
    if free.any():
        A = np.block([[np.zeros((1, 1)), y[free][None]], [y[free][:, None], Q[np.ix_(free, free)]]]).astype(float)
        b = -(y * (Q @ a - 1))[free].mean()
        for _ in range(6):
            residual = np.concatenate([[y @ a], (Q @ a - 1 + y * b)[free]])
            change = np.linalg.lstsq(A, residual.astype(float), rcond=1e-14)[0]
            b -= change[0]
            a[free] -= change[1:]
    return a if violation(Q, y, C, a) < violation(Q, y, C, inside) else inside


def violation(Q: Array, y: Array, C: Any, a: Array) -> float:
    """Largest violation of the optimality conditions at the best offset."""
    h = y * (Q @ a)
    g = y * (h + centre(h, y)) - 1
    wrong = np.where(a <= 0, -g, np.where(a >= C, g, np.abs(g)))
    return float(max(wrong.max(), (-a).max(), (a - C).max(), abs(y @ a), 0))


def _reach(values: Array, change: Array) -> Any:
    falling = change < 0
    return min(Real(1), (-values[falling] / change[falling]).min()) if falling.any() else Real(1)


def _solve(matrix: Array, right: Array) -> Array:
    """Gaussian elimination for a positive definite matrix; NumPy's own solver knows double precision only."""
    A, B = matrix.copy(), right.copy()
    for k in range(len(A)):
        factors = A[k + 1 :, k] / A[k, k]
        A[k + 1 :, k + 1 :] -= factors[:, None] * A[k, k + 1 :]
        B[k + 1 :] -= factors[:, None] * B[k]
    for k in range(len(A) - 1, -1, -1):
        B[k] = (B[k] - A[k, k + 1 :] @ B[k + 1 :]) / A[k, k]
    return B
