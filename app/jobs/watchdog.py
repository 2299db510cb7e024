"""Ends work that computes without progress, such as decoding a video that was made to be slow.

A limit on the total time would limit the length of videos, so the time between two steps is limited.
"""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from sqlalchemy.exc import SQLAlchemyError

from app.jobs.context import TaskContext
from app.jobs.outcome import report_failure
from app.storage.ticking import ticking

__all__ = ["watched"]

_log = logging.getLogger("tsr.worker")


@contextmanager
def watched(
    task: TaskContext, most: float, sentence: Callable[[], str], every: float = 1.0
) -> Iterator[Callable[[], None]]:
    """Fail the job and end its process when a step computes for too long.

    The step may be one call of a decoder that never returns: nothing but the end of the process ends that. Waiting for
    a slow disk costs no computing and is no reason.

    Args:
        task: the job.
        most: processor time of this process that one step may take, on all its threads together, seconds.
        sentence: what people are reported then.
        every: between two looks, seconds.

    Yields:
        To be called after each step.
    """
    began = time.process_time()

    def step() -> None:
        nonlocal began
        began = time.process_time()

    def look() -> None:
        if time.process_time() - began > most:
            _log.warning("Job %s computes without getting on; its process ends.", task.job.id)
            with suppress(SQLAlchemyError):  # else the supervisor finds a dead worker, and tells that
                report_failure(task, sentence())
            os._exit(1)

    with ticking("watchdog", every, look):
        yield step
