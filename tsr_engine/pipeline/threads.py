"""One thread for the linear algebra of training, so sums have one order on any number of cores.

A run needs no such block: it multiplies with :mod:`tsr_engine.products`.
"""

from __future__ import annotations

from contextlib import AbstractContextManager

from threadpoolctl import threadpool_limits

__all__ = ["one_blas_thread"]


def one_blas_thread() -> AbstractContextManager[object]:
    """A block in which BLAS runs on one thread."""
    limits: AbstractContextManager[object] = threadpool_limits(limits=1, user_api="blas")
    return limits
