"""Describes a kind of job to the workers: its task, and what they can prepare for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from app.jobs.context import TaskContext
from app.jobs.kinds import JobKind, JobKinds
from app.settings import Settings
from app.storage.database import Database
from tsr_engine.json_shapes import JsonObject

Task = Callable[[TaskContext], None]
"""Does one job in a worker. It stores its result with :meth:`app.jobs.context.TaskContext.complete`; people see the
sentence of a ``TsrError`` that it raises.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskKind(JobKind):
    """One kind of job with its task.

    Attributes:
        load: imports the task; the engine is large, and the server does not need it.
        prepare: steps of at most a second that an idle worker does in advance, after ``load``.
        expect: (settings, database, data) prepares for a job that a person may request soon.
    """

    load: Callable[[], Task]
    prepare: tuple[Callable[[], object], ...] = ()
    expect: Callable[[Settings, Database, JsonObject], None] | None = None


def preparations(kinds: JobKinds[TaskKind]) -> Iterator[Callable[[], object]]:
    """Steps that an idle worker of the short lane takes in advance, so that the next job starts at once.

    In a new process a what-if would spend three seconds on loading the engine, a recording one second on the Rerun SDK.

    Yields:
        Steps of at most a second, the most often awaited first; jobs may come between two of them.
    """
    for kind in kinds:
        if kind.lane == "short":
            yield kind.load
            yield from kind.prepare
