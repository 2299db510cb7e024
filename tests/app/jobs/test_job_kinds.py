"""Kinds of jobs: an invented kind is handled like real ones, because the queue knows none of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_type_hints

import pytest

from app.events import EventBus
from app.job_kinds import KINDS
from app.jobs.context import Stopped, TaskContext
from app.jobs.kinds import JobKinds
from app.jobs.outcome import notify_subject
from app.jobs.queue import MAX_CRASHES, JobQueue
from app.jobs.supervisor import Supervisor
from app.jobs.tasks import TaskKind, preparations
from app.jobs.worker import execute
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job
from tsr_engine.errors import InputError

SUBJECT = "s" * 32


@dataclass
class Bakery:
    """A task outside the tool's packages that records its calls."""

    database: Database
    home: Path
    reported: list[tuple[str, str | None]] = field(default_factory=list)
    cleared: list[tuple[Path, str]] = field(default_factory=list)
    work: Callable[[TaskContext], None] = lambda _: None

    def __post_init__(self) -> None:
        kind = TaskKind(
            name="bake", lane="short", load=lambda: self.work, on_failed=self.settle, clear=self.clear, by_frame=True
        )
        self.kinds = JobKinds([kind], worker="no.such.module")
        self.jobs = JobQueue(EventBus(), self.kinds)

    def settle(self, session: object, events: EventBus, job: Job, state: str, error: str | None) -> None:
        assert (job.subject, events) == (SUBJECT, self.jobs.events)
        self.reported.append((state, error))

    def clear(self, home: Path, subject: str) -> None:
        self.cleared.append((home, subject))

    def submit(self) -> str:
        """One job."""
        with self.database.write() as session:
            return self.jobs.submit(session, "bake", SUBJECT).id

    def claim(self, job_id: str) -> TaskContext:
        """A job as a worker holds it."""
        with self.database.write() as session:
            job = self.jobs.claim(session, job_id)
        assert job is not None
        return TaskContext(
            Settings(home=self.home), self.database, self.jobs.events, self.jobs, job, leaving=lambda: False
        )

    def state(self, job_id: str) -> str:
        """State of a job."""
        with self.database.read() as session:
            return session.get_one(Job, job_id).state


@pytest.fixture
def bakery(database: Database, tmp_path: Path) -> Bakery:
    return Bakery(database, tmp_path)


def fail(_: TaskContext) -> None:
    raise InputError("The flour is gone.")


def stop(_: TaskContext) -> None:
    raise Stopped


def test_a_finished_job_calls_no_hook(bakery: Bakery) -> None:
    seen: list[str] = []
    bakery.work = lambda task: seen.append(task.job.subject)
    job = bakery.submit()
    execute(bakery.claim(job), bakery.kinds)
    assert (bakery.state(job), seen, bakery.reported, bakery.cleared) == ("done", [SUBJECT], [], [])


def test_a_failed_job_calls_the_hooks_of_its_kind(bakery: Bakery) -> None:
    bakery.work = fail
    job = bakery.submit()
    execute(bakery.claim(job), bakery.kinds)
    assert bakery.state(job) == "failed"
    assert bakery.reported == [("failed", "The flour is gone.")]
    assert bakery.cleared == [(bakery.home, SUBJECT)]


def test_hooks_of_returned_and_cancelled_jobs(bakery: Bakery) -> None:
    bakery.work = stop
    job = bakery.submit()
    execute(bakery.claim(job), bakery.kinds)
    assert (bakery.state(job), bakery.reported, bakery.cleared) == ("queued", [("queued", None)], [])
    task = bakery.claim(job)
    with bakery.database.write() as session:
        bakery.jobs.cancel(session, SUBJECT)
    execute(task, bakery.kinds)
    assert bakery.state(job) == "cancelled"
    assert bakery.reported[1:] == [("cancelled", None)]
    assert bakery.cleared == [(bakery.home, SUBJECT)]


def cancelled(bakery: Bakery) -> list[str]:
    """The jobs that a person's request cancels."""
    with bakery.database.write() as session:
        return [job.id for job in bakery.jobs.cancel(session, SUBJECT)]


def test_a_job_that_is_done_cannot_be_cancelled(bakery: Bakery) -> None:
    def work(task: TaskContext) -> None:
        with task.complete():
            pass
        assert cancelled(bakery) == []

    bakery.work = work
    job = bakery.submit()
    execute(bakery.claim(job), bakery.kinds)
    assert (bakery.state(job), bakery.reported, bakery.cleared) == ("done", [], [])


def test_a_job_that_stores_nothing_at_its_end_can_be_cancelled_until_then(bakery: Bakery) -> None:
    job = bakery.submit()
    bakery.work = lambda _: cancelled(bakery)  # type: ignore[assignment, return-value]
    execute(bakery.claim(job), bakery.kinds)
    assert (bakery.state(job), bakery.reported) == ("cancelled", [("cancelled", None)])


def test_a_job_whose_result_cannot_be_stored_is_not_done(bakery: Bakery) -> None:
    def work(task: TaskContext) -> None:
        with task.complete():
            raise InputError("The oven is full.")

    bakery.work = work
    job = bakery.submit()
    execute(bakery.claim(job), bakery.kinds)
    assert (bakery.state(job), bakery.reported) == ("failed", [("failed", "The oven is full.")])


def test_the_supervisor_settles_a_job_that_keeps_dying(bakery: Bakery) -> None:
    job = bakery.submit()
    for _ in range(MAX_CRASHES):
        task = bakery.claim(job)
        Supervisor(task.settings, bakery.database, bakery.jobs).requeue_dead(task.job, "crashed")
    assert [state for state, _ in bakery.reported] == ["queued"] * (MAX_CRASHES - 1) + ["failed"]
    assert "died 3 times before its first frame" in (bakery.reported[-1][1] or "")
    assert bakery.cleared == [(bakery.home, SUBJECT)]


def test_a_job_of_a_newer_version_calls_no_hook(bakery: Bakery) -> None:
    with bakery.database.write() as session:
        newer = bakery.jobs.submit(session, "fly", SUBJECT)
        notify_subject(session, bakery.jobs, newer, "failed", "There is no such work.")
    with bakery.database.read() as session:
        assert bakery.jobs.waiting_ids(session, "long") == [newer.id]
    assert bakery.reported == []


def test_a_worker_fails_a_job_of_a_newer_version_with_a_reason(bakery: Bakery) -> None:
    with bakery.database.write() as session:
        newer = bakery.jobs.submit(session, "fly", SUBJECT).id
    execute(bakery.claim(newer), bakery.kinds)
    with bakery.database.read() as session:
        job = session.get_one(Job, newer)
    message = 'This server cannot do jobs of the kind "fly". Update tsr, then start it again.'
    assert (job.state, job.error, bakery.reported) == ("failed", message, [])


def test_short_kinds_are_prepared_in_order_and_names_are_unique(bakery: Bakery) -> None:
    steps: list[str] = []

    def kind(name: str, lane: str) -> TaskKind:
        load, ready = (lambda text=text: steps.append(f"{text} {name}") for text in ("load", "ready"))
        return TaskKind(name=name, lane=lane, load=load, on_failed=bakery.settle, prepare=(ready,))  # type: ignore[arg-type]

    kinds = JobKinds([kind("a", "short"), kind("b", "long"), kind("c", "short")], worker="w")
    for step in preparations(kinds):
        step()
    assert steps == ["load a", "ready a", "load c", "ready c"]
    with pytest.raises(ValueError, match="must have different names"):
        JobKinds([kind("a", "short"), kind("a", "long")], worker="w")


@pytest.mark.parametrize("kind", list(KINDS), ids=lambda kind: kind.name)
def test_the_task_of_a_kind_takes_a_job(kind: TaskKind) -> None:
    assert get_type_hints(kind.load()) == {"task": TaskContext, "return": type(None)}
