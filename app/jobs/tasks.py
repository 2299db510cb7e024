"""What a worker can do, and what it gives a task to work with."""

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

__all__ = ["Stopped", "Task", "TaskContext", "task_of"]

_ASK = 0.25
"""Seconds between looks at the cancel flag."""


class Stopped(Exception):
    """The task has been asked to stop and has done so."""


@dataclass(slots=True)
class TaskContext:
    """One claimed job, and everything it may touch."""

    settings: Settings
    database: Database
    events: EventBus
    jobs: JobQueue
    job: Job
    leaving: Callable[[], bool]
    """True: this process has been told to end; give the job back."""
    _asked: float = field(default=0.0)
    _cancelled: bool = field(default=False)

    @contextmanager
    def write(self) -> Iterator[Session]:
        """A writing session in which the job is still ours.

        Raises:
            Fenced: it is not.
        """
        with self.database.write() as session:
            self.jobs.held(session, self.job.id, self.job.token)
            yield session

    def reached(self, session: Session, position: int) -> None:
        """Note how far the job is, so that a crash can be told from no progress."""
        self.jobs.held(session, self.job.id, self.job.token).position = position

    def cancelled(self) -> bool:
        """Whether a person wants the job to stop."""
        now = time.monotonic()
        if not self._cancelled and now - self._asked > _ASK:
            self._asked = now
            with self.database.read() as session:
                job = session.get(Job, self.job.id)
                self._cancelled = job is None or job.cancel or job.token != self.job.token
        return self._cancelled

    def stop(self) -> bool:
        """Whether to stop, for whatever reason."""
        return self.leaving() or self.cancelled()


Task = Callable[[TaskContext], None]


def task_of(kind: str) -> Task:
    """The function for a kind of job; imported when it is needed, for the engine is large.

    Raises:
        KeyError: there is no such kind.
    """
    if kind == "import":
        from app.videos.importing import import_video

        return import_video
    if kind == "track":
        from app.runs.task import track

        return track
    if kind == "retrain":
        from app.training.task import retrain_models

        return retrain_models
    if kind == "export":
        from app.exchange.task import export

        return export
    if kind == "whatif":
        from app.whatif.task import run_whatif

        return run_whatif
    if kind == "glance":
        from app.videos.glancing import make_glances

        return make_glances
    if kind == "bundle":
        from app.bundles.task import make_run_bundle

        return make_run_bundle
    if kind == "recording":
        from app.recordings.task import record_run

        return record_run
    if kind == "scene":
        from app.space.task import make_scene

        return make_scene
    raise KeyError(kind)
