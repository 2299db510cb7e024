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
from app.storage.ticking import ticking

__all__ = ["EVERY", "beating"]

EVERY: Final = 10.0
"""Seconds between two beats."""


@contextmanager
def beating(database: Database, job: Job, every: float = EVERY) -> Iterator[None]:
    """Write the heartbeat of a claimed job until the block ends; on SQLite nobody needs one.

    The steps of a task have nothing to do with it: how far an export is says nothing about whether its process lives.

    Args:
        database: where the queue is.
        job: as it was claimed; once it belongs to another process, its heartbeat is let alone.
        every: seconds between two beats.
    """
    if database.is_sqlite:
        yield
        return
    mine = update(Job).where(Job.id == job.id, Job.token == job.token, Job.state == "running")

    def beat() -> None:
        with suppress(SQLAlchemyError), database.write() as session:  # the next beat may reach it again
            session.execute(mine.values(heartbeat=datetime.now(UTC)))

    with ticking("heartbeat", every, beat):
        yield
