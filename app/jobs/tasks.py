"""Describes a kind of job to the workers: its task, and what they can prepare for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.jobs.context import TaskContext
from app.jobs.kinds import JobKind
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
