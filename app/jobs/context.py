"""The context of a task in a worker: settings, database, events, and its job."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.queue import JobQueue
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job

_CANCEL_CHECK_S = 0.25
"""Seconds between checks of the cancel flag."""


class Stopped(Exception):
    """The task has stopped on request."""


@dataclass(slots=True)
class TaskContext:
    """One claimed job, with everything that its task may use."""

    settings: Settings
    database: Database
    events: EventBus
    jobs: JobQueue
    job: Job
    leaving: Callable[[], bool]
    """Returns whether this process must end and give the job back."""
    completed: bool = field(default=False, init=False)
    """Whether the job is done: its task has called :meth:`complete`."""
    _checked_at: float = field(default=0.0)
    _cancelled: bool = field(default=False)

    @contextmanager
    def write(self, *, durable: bool = True) -> Iterator[Session]:
        """Yield a writing session that still holds the job.

        Args:
            durable: as for :meth:`app.storage.database.Database.write`.

        Raises:
            Fenced: the job belongs to another process.
        """
        with self.database.write(durable=durable) as session:
            self.jobs.require_claim(session, self.job.id, self.job.token)
            yield session

    @contextmanager
    def complete(self, *, durable: bool = True) -> Iterator[Session]:
        """Yield the last writing session, in which the task stores its result; it ends the job as done.

        Result and job are stored in one transaction, so a job is either done or can still be cancelled.

        Args:
            durable: as for :meth:`app.storage.database.Database.write`.

        Raises:
            Stopped: a person has cancelled the job, so nothing may be stored. Do not catch it.
            Fenced: the job belongs to another process.
        """
        with self.database.write(durable=durable) as session:
            if self.jobs.require_claim(session, self.job.id, self.job.token).cancel:
                raise Stopped
            yield session
            self.jobs.finish(session, self.job.id, self.job.token, "done")
        self.completed = True

    @property
    def has_notes(self) -> bool:
        """Whether jobs of this kind can have a note."""
        kind = self.jobs.kinds.get(self.job.kind)
        return kind is not None and kind.on_note is not None

    def note(self, note: str) -> None:
        """Tell people what the job does besides its progress, if its kind has notes; thread-safe.

        Args:
            note: a few words for a progress line; empty: nothing to say.

        Raises:
            Fenced: the job has ended, or belongs to another process.
        """
        with self.write(durable=False) as session:
            self.jobs.note(session, self.job, note)

    def record_progress(self, session: Session, position: int) -> None:
        """Record the progress of the job, so that a crash can be distinguished from no progress."""
        self.jobs.require_claim(session, self.job.id, self.job.token).position = position

    def is_cancelled(self) -> bool:
        """Whether a person has cancelled the job."""
        now = time.monotonic()
        if not self._cancelled and now - self._checked_at > _CANCEL_CHECK_S:
            self._checked_at = now
            with self.database.read() as session:
                job = session.get(Job, self.job.id)
                self._cancelled = job is None or job.cancel or job.token != self.job.token
        return self._cancelled

    def should_stop(self) -> bool:
        """Whether to stop for any reason."""
        return self.leaving() or self.is_cancelled()
