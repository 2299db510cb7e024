"""``IncrementalSVC``: a support vector machine that learns and unlearns one sample at a time, exactly.

Cauwenberghs & Poggio, "Incremental and decremental support vector machine learning", NIPS 2000; Diehl &
Cauwenberghs, "SVM incremental learning, adaptation and optimization", IJCNN 2003. It is the online detector
``M_on`` of section III-D.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tsr_engine.linear_algebra import dot, product
from tsr_engine.online.completion import add_sample, complete, gradient, violation
from tsr_engine.online.kernels import LINEAR, RBF, kernel_row, signed_kernel
from tsr_engine.online.repair import repair
from tsr_engine.online.sample_store import SampleStore
from tsr_engine.online.solution_path import follow_path
from tsr_engine.online.validation import as_indices, as_labels, as_samples, check_parameters, check_scale
from tsr_engine.records import FloatArray

__all__ = ["IncrementalSVC"]

IndexArray = NDArray[np.intp]


class IncrementalSVC:
    """Exact incremental and decremental two-class C-SVC.

    After any sequence of :meth:`partial_fit` and :meth:`unlearn` the model is the batch solution on the remaining
    samples, up to rounding. Samples keep their order; :meth:`unlearn` closes the gaps.

    The offset of a batch solution is not unique if no coefficient lies strictly between 0 and ``C``. As in libsvm, the
    offset is then the middle of the interval of optimal offsets. If all samples have one class, the interval has only
    one end, and the offset is that end (``+1`` or ``-1``). Without samples it is 0.

    The same sequence of calls gives the same bits for any number of threads. Rounding grows with the kernel:
    :meth:`kkt_residual` is of the order of ``1e-16 C max K(x, x)``, so features of about unit size are best. It can be
    1e-12 to 1e-10 times ``C max K(x, x)``, rarely 1e-9 times, if the kernel hardly distinguishes samples (its matrix of
    the margin vectors is singular to ten digits, or coefficients lie within a share of 1e-12 of a bound).

    Args:
        C: upper bound of the coefficients, in (0, 1e12].
        kernel: ``"linear"`` (``<x, z>``) or ``"rbf"`` (``exp(-gamma |x - z|^2)``).
        gamma: coefficient of the RBF kernel, > 0; ``None`` for ``1 / n_features``. Unused by a linear kernel.

    Attributes:
        X_: shape (n, d), the current samples.
        y_: shape (n,), their labels, -1 or +1.
        alpha_: shape (n,), dual coefficients in [0, C].
        intercept_: offset b.
        margin_, error_, reserve_: indices of the sets S (0 < alpha < C), E (alpha = C), R (alpha = 0).
        support_: indices with alpha > 0.
        dual_coef_: shape (n,), ``y_i alpha_i``.
        coef_: shape (d,), the weights of a linear model.
        n_features_in_: d; 0 before the first sample.
        dual_objective_: value of the maximised dual.

    Examples:
        >>> svm = IncrementalSVC(C=1.0).partial_fit([[0.0], [2.0]], [-1, 1])
        >>> svm.decision_function([[2.0], [1.0]]).round(6).tolist()
        [1.0, 0.0]
        >>> len(svm.unlearn([0]).y_)
        1
    """

    def __init__(self, C: float = 1.0, kernel: Literal["linear", "rbf"] = "linear", gamma: float | None = None) -> None:
        check_parameters(C, kernel, gamma)
        self.C = float(C)
        self.kernel = kernel
        self.gamma = None if gamma is None else float(gamma)
        self._store = SampleStore(0)
        self._b = 0.0
        self._size = 0
        self._coef: FloatArray | None = None

    # -- learning ------------------------------------------------------------------------------------------

    def partial_fit(self, X: ArrayLike, y: ArrayLike) -> IncrementalSVC:
        """Learn samples one by one.

        Args:
            X: shape (m, d), finite; m may be 0. With a linear kernel ``C |x|^2`` is at most 1e12.
            y: shape (m,), labels -1 or +1.

        Returns:
            The model itself.

        Raises:
            ValueError: a shape, label or value is wrong; the model is unchanged.
        """
        samples = as_samples(X, self._store.features)
        labels = as_labels(y, len(samples))
        if self.kernel == "linear":
            check_scale(samples, self.C)
        if not len(samples):
            return self
        if not self._store.features:
            self._store = SampleStore(samples.shape[1])
        for x, label in zip(samples, labels, strict=True):
            self._add(x, label)
        self._coef = None
        return self

    def unlearn(self, indices: int | Iterable[int] | NDArray[np.generic]) -> IncrementalSVC:
        """Unlearn samples; later samples move up in ``X_``.

        Args:
            indices: indices of ``X_`` *before* the call, in 0..n-1, without repetition.

        Returns:
            The model itself.

        Raises:
            IndexError: an index is out of range; the model is unchanged.
            ValueError: an index occurs twice or is not a whole number; the model is unchanged.
        """
        chosen = as_indices(indices, len(self._store))
        for position in sorted(chosen, reverse=True):
            self._remove(position)
        self._coef = None
        return self

    # -- use -----------------------------------------------------------------------------------------------

    def decision_function(self, X: ArrayLike) -> FloatArray:
        """``sum_j y_j alpha_j K(x_j, x) + b`` for each row of X, shape (m,).

        Raises:
            ValueError: the shape or a value is wrong.
        """
        samples = as_samples(X, self._store.features)
        if not len(self._store) or not len(samples):
            return np.full(len(samples), self._b)
        if self.kernel == "linear":
            return np.asarray(product(samples, self.coef_[:, None])[:, 0] + self._b)
        store = self._store
        weights = store.y[: store.n] * store.alpha[: store.n]
        values = np.empty(store.n)
        result = np.empty(len(samples))
        for k, x in enumerate(samples):
            kernel_row(store.X, store.n, x, RBF, self._width(), values)
            result[k] = dot(weights, values)
        return result + self._b

    def predict(self, X: ArrayLike) -> NDArray[np.int64]:
        """Labels -1 or +1, shape (m,); +1 for a decision value of 0."""
        return np.where(self.decision_function(X) >= 0.0, 1, -1).astype(np.int64)

    def kkt_residual(self) -> float:
        """Largest violation of the optimality conditions, computed from samples and coefficients.

        The violation is ``max(0, -g)`` for alpha = 0, ``max(0, g)`` for alpha = C, and ``|g|`` otherwise.
        ``|sum y alpha|`` and coefficients outside [0, C] count as well.
        """
        store = self._store
        n = store.n
        if not n:
            return 0.0
        signed = signed_kernel(store.X[:n], store.y[:n], self._kind(), self._width())
        checked = store.dual(self.C)._replace(Q=signed, g=np.empty(n))
        gradient(checked, self._b)
        return float(violation(checked))

    def copy(self) -> IncrementalSVC:
        """An independent model with the same state, bit for bit."""
        twin = IncrementalSVC.__new__(IncrementalSVC)
        twin.__dict__.update(self.__dict__)
        twin._store = self._store.copy()
        return twin

    def __repr__(self) -> str:
        return f"IncrementalSVC(C={self.C}, kernel={self.kernel!r}, gamma={self.gamma})"

    # -- learned state -------------------------------------------------------------------------------------

    @property
    def X_(self) -> FloatArray:  # noqa: N802
        """The current samples, shape (n, d)."""
        return self._store.X[self._store.order]

    @property
    def y_(self) -> NDArray[np.int64]:
        """Labels -1 or +1, shape (n,)."""
        return self._store.y[self._store.order].astype(np.int64)

    @property
    def alpha_(self) -> FloatArray:
        """Dual coefficients in [0, C], shape (n,)."""
        return self._store.alpha[self._store.order]

    @property
    def intercept_(self) -> float:
        """Offset b."""
        return self._b

    @property
    def margin_(self) -> IndexArray:
        """Indices of S, 0 < alpha < C."""
        return np.flatnonzero((self.alpha_ > 0.0) & (self.alpha_ < self.C))

    @property
    def error_(self) -> IndexArray:
        """Indices of E, alpha = C."""
        return np.flatnonzero(self.alpha_ >= self.C)

    @property
    def reserve_(self) -> IndexArray:
        """Indices of R, alpha = 0."""
        return np.flatnonzero(self.alpha_ <= 0.0)

    @property
    def support_(self) -> IndexArray:
        """Indices with alpha > 0."""
        return np.flatnonzero(self.alpha_ > 0.0)

    @property
    def dual_coef_(self) -> FloatArray:
        """``y_i alpha_i``, shape (n,)."""
        return np.asarray(self.alpha_ * self.y_)

    @property
    def n_features_in_(self) -> int:
        """Number of features d; 0 before the first sample."""
        return self._store.features

    @property
    def coef_(self) -> FloatArray:
        """Weights of a linear model, shape (d,).

        Raises:
            AttributeError: the kernel is not linear.
        """
        if self.kernel != "linear":
            raise AttributeError("IncrementalSVC has 'coef_' only with kernel='linear'.")
        if self._coef is None:
            self._coef = product(self.dual_coef_[None], self.X_)[0]
            self._coef.flags.writeable = False
        return self._coef

    @property
    def dual_objective_(self) -> float:
        """``sum alpha - 1/2 alpha' Q alpha``; the maximum of the dual."""
        alpha = self._store.alpha[: self._store.n]
        curved = product(alpha[None], self._store.Q[: len(alpha), : len(alpha)])[0]
        return float(alpha.sum() - 0.5 * dot(curved, alpha))

    # -- the steps -----------------------------------------------------------------------------------------

    def _add(self, x: FloatArray, label: float) -> None:
        store = self._store
        slot = store.append(x, label)
        n = store.n
        row = store.Q[slot]
        kernel_row(store.X, n, store.X[slot], self._kind(), self._width(), row)
        row[:n] *= store.y[:n] * label
        store.diagonal[slot] = row[slot]
        store.Q[:n, slot] = row[:n]
        store.g[slot] = dot(row[:n], store.alpha[:n]) + label * self._b - 1.0
        dual = store.dual(self.C)
        self._b, self._size, exact = add_sample(dual, self._b, self._size, slot)
        if not exact:
            self._b, self._size = repair(dual)

    def _remove(self, position: int) -> None:
        store = self._store
        slot = int(store.order[position])
        self._size = store.leave_margin(slot, self._size)
        exact = store.alpha[slot] == 0.0
        if not exact:
            self._b, self._size, exact = follow_path(store.dual(self.C), self._b, self._size, slot, False)
        store.drop(position, self._size)
        dual = store.dual(self.C)
        if exact:
            self._b, self._size, exact = complete(dual, self._b, self._size)
        if not exact:
            self._b, self._size = repair(dual)

    def _kind(self) -> int:
        return LINEAR if self.kernel == "linear" else RBF

    def _width(self) -> float:
        return 1.0 / self._store.features if self.gamma is None else self.gamma
