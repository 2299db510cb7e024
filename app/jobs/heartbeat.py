"""Heartbeats of running jobs, for servers on other machines that cannot see the lock of the process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from typing import Final

from sqlalchemy import update
from sqlalchemy.exc import SQLAlchemyError

from app.storage.database import Database
from app.storage.models import Job
from tsr_engine.periodic import call_periodically

INTERVAL_S: Final = 10.0
"""Seconds between heartbeats."""


@contextmanager
def heartbeat(database: Database, job: Job, interval: float = INTERVAL_S) -> Iterator[None]:
    """Write the heartbeat of a claimed job until the block ends; SQLite needs none.

    The heartbeat does not depend on the task's progress, which does not show whether the process lives.

    Args:
        database: with the queue.
        job: as claimed; the heartbeat stops when it belongs to another process.
        interval: seconds between heartbeats.
    """
    if database.is_sqlite:
        yield
        return
    claimed = update(Job).where(Job.id == job.id, Job.token == job.token, Job.state == "running")

    def beat() -> None:
        with suppress(SQLAlchemyError), database.write() as session:  # the next heartbeat may succeed again
            session.execute(claimed.values(heartbeat=datetime.now(UTC)))

    with call_periodically("heartbeat", interval, beat):
        yield
