"""Limits BLAS or OpenCV to one thread.

Training needs one BLAS thread, so that sums have the same order on any number of cores. A run does not need it, because
it multiplies with :mod:`tsr_engine.linear_algebra`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager

import cv2
from threadpoolctl import threadpool_limits


def one_blas_thread() -> AbstractContextManager[object]:
    """A block in which BLAS runs on one thread."""
    limits: AbstractContextManager[object] = threadpool_limits(limits=1, user_api="blas")
    return limits


@contextmanager
def one_opencv_thread() -> Iterator[None]:
    """A block in which OpenCV runs on one thread."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)
