"""The dual problem of the incremental SVM and the state of its solution, as its kernels see them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tsr_engine.records import FloatArray


class Dual(NamedTuple):
    """The C-SVC dual on n samples. Kernels change the solution and use the scratch in place.

    Arrays may be longer than stated. The offset and the number of margin vectors, ``size``, change with each step, so
    that kernels take and return them as values.
    """

    n: int
    """Number of samples."""
    C: float
    """Upper bound of alpha."""
    scale: float
    """Largest diagonal element of Q: the unit of all tolerances."""
    Q: FloatArray
    """Shape (n, n), signed kernel matrix."""
    y: FloatArray
    """Shape (n,), labels, -1 or +1."""
    alpha: FloatArray
    """Shape (n,), coefficients."""
    g: FloatArray
    """Shape (n,), gradient."""
    status: NDArray[np.int8]
    """Shape (n,), set of each sample: ``RESERVE``, ``MARGIN``, ``ERROR`` or ``CANDIDATE``."""
    S: NDArray[np.int64]
    """Shape (size,), margin vectors."""
    R: FloatArray
    """Shape (size + 1, size + 1), inverse of the bordered margin matrix."""
    beta: FloatArray
    """Scratch, shape (n + 1,)."""
    slope: FloatArray
    """Scratch, shape (n,)."""
    blocked: NDArray[np.bool_]
    """Scratch, shape (n,)."""
