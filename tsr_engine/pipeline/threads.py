"""One thread for linear algebra: its matrices are small here, and sums then have one order on every machine."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

from threadpoolctl import threadpool_limits

__all__ = ["one_blas_thread"]


def one_blas_thread() -> AbstractContextManager[Any]:
    """A block in which BLAS runs on one thread.

    Waking a second thread costs more than it saves on products of a few hundred rows, above all while the detector
    uses both cores.
    """
    limits: AbstractContextManager[Any] = threadpool_limits(limits=1, user_api="blas")
    return limits
