"""Notes on jobs that wait while a worker compiles kernels, so that people know why they take longer to start."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pkgutil import resolve_name
from typing import Final

from sqlalchemy.exc import SQLAlchemyError

from app.jobs.context import TaskContext
from app.jobs.lanes import Lane
from app.jobs.queue import Fenced, JobQueue
from app.storage.database import Database
from app.storage.models import Job
from tsr_engine.periodic import call_periodically

CHECK_INTERVAL_S: Final = 0.25
"""Seconds between checks."""
_COMPILING_MODULE: Final = "tsr_engine.compilation"
"""Imported by workers that compile: the compiler takes half a second to import, and other workers do without."""


@contextmanager
def note_compilation(task: TaskContext) -> Iterator[None]:
    """Keep the note of a running job during a block, if its kind has notes.

    A thread writes the note, because a kernel may be compiled within a transaction of the task.
    """
    if not task.has_notes:
        yield
        return

    def report(note: str) -> bool:
        with suppress(Fenced, SQLAlchemyError):  # the job has ended, or the next check tries again
            task.note(note)
            return True
        return False

    with resolve_name(f"{_COMPILING_MODULE}:report_compilation")(report, CHECK_INTERVAL_S):
        yield


@contextmanager
def note_preparation(database: Database, jobs: JobQueue, lane: Lane) -> Iterator[None]:
    """Keep the notes of the jobs that wait in a lane during a block, in which its worker prepares for them.

    The task of a job removes the note when it begins.
    """
    noted: set[str] = set()
    with resolve_name(f"{_COMPILING_MODULE}:watch_compilation")() as current_note:

        def update_notes() -> None:
            nonlocal noted
            note = current_note()
            if not note and not noted:
                return
            with suppress(SQLAlchemyError):  # the next check tries again
                with database.read() as session:
                    waiting = set(jobs.waiting_ids(session, lane))
                changed = waiting - noted if note else waiting & noted
                if changed:
                    with database.write(durable=False) as session:
                        for job in (session.get_one(Job, job_id) for job_id in sorted(changed)):
                            if job.state == "queued":
                                jobs.note(session, job, note)
                noted = waiting if note else set()

        with call_periodically("compilation", CHECK_INTERVAL_S, update_notes):
            yield
