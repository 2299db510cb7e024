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
from tsr_engine.periodic import call_periodically

_log = logging.getLogger("tsr.worker")


@contextmanager
def watchdog(
    task: TaskContext, max_cpu: float, message: Callable[[], str], interval: float = 1.0
) -> Iterator[Callable[[], None]]:
    """Fail the job and end its process if a step computes for too long.

    The step may be one call of a decoder that never returns, so only the end of the process stops it. Waiting for a
    slow disk takes no processor time and does not count.

    Args:
        task: the job.
        max_cpu: maximum processor time of one step on all threads of this process together, seconds.
        message: returns the error message.
        interval: seconds between checks.

    Yields:
        A function to call after each step.
    """
    step_start = time.process_time()

    def step() -> None:
        nonlocal step_start
        step_start = time.process_time()

    def check() -> None:
        if time.process_time() - step_start > max_cpu:
            _log.warning("Job %s computes without progress; its process ends.", task.job.id)
            with suppress(SQLAlchemyError):  # otherwise the supervisor finds a dead worker and reports that
                report_failure(task, message())
            os._exit(1)

    with call_periodically("watchdog", interval, check):
        yield step
