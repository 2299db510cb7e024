"""While the disk is full, workers and their supervisor wait, report it once, and then continue."""

from __future__ import annotations

import errno
import logging
import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sqlalchemy.exc import OperationalError

from app.events import EventBus
from app.jobs import worker
from app.jobs.context import TaskContext
from app.jobs.kinds import JobKinds
from app.jobs.locks import JobLock, unstored_ends
from app.jobs.queue import JobQueue
from app.jobs.supervisor import Supervisor
from app.jobs.tasks import TaskKind
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job

FULL = OperationalError("INSERT", {}, sqlite3.OperationalError("database or disk is full"))
DISK_FULL = OSError(errno.ENOSPC, "No space left on device")

ClaimJob = Callable[[Exception], tuple[TaskContext, JobKinds[TaskKind]]]


@pytest.fixture
def claimed(database: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ClaimJob:
    """Claims a job whose task raises an error; returns it and the kinds of jobs."""
    monkeypatch.setattr(worker, "RETRY_DELAY_S", 0.01)

    def make(error: Exception) -> tuple[TaskContext, JobKinds[TaskKind]]:
        def work(_: TaskContext) -> None:
            raise error

        kind = TaskKind(name="bake", lane="short", load=lambda: work, on_failed=lambda *_: None)
        kinds = JobKinds([kind], worker="no.such.module")
        jobs = JobQueue(EventBus(), kinds)
        with database.write() as session:
            job = jobs.claim(session, jobs.submit(session, "bake", "s" * 32).id)
        assert job is not None
        return TaskContext(Settings(home=tmp_path), database, jobs.events, jobs, job, leaving=lambda: False), kinds

    return make


def final_state(task: TaskContext) -> tuple[str, str | None]:
    with task.database.read() as session:
        job = session.get_one(Job, task.job.id)
        return job.state, job.error


def warnings(log: pytest.LogCaptureFixture) -> list[str]:
    assert not any(record.exc_info for record in log.records), "no traceback for what is nobody's fault"
    return [record.getMessage() for record in log.records if record.levelno >= logging.WARNING]


@pytest.mark.parametrize("error", [FULL, DISK_FULL])
def test_a_job_on_a_full_disk_says_so(claimed: ClaimJob, error: Exception, caplog: pytest.LogCaptureFixture) -> None:
    task, kinds = claimed(error)
    worker.execute(task, kinds)
    assert final_state(task) == ("failed", "The disk is full. Free some space, then try again.")
    assert len(warnings(caplog)) <= 1


def test_the_end_of_a_job_is_stored_once_there_is_room(
    claimed: ClaimJob, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    task, kinds = claimed(DISK_FULL)
    report, attempts, reasons = worker.report_failure, iter([FULL, FULL, FULL]), list[dict[str, str]]()

    def at_last(task: TaskContext, message: str) -> None:
        reasons.append(unstored_ends(task.settings.home))
        for error in attempts:
            raise error
        report(task, message)

    monkeypatch.setattr(worker, "report_failure", at_last)
    lock = JobLock(task.settings.home, task.job.id)
    assert lock.acquire()
    worker.execute(task, kinds)
    lock.release()
    assert reasons == [{}, *[{task.job.id: "the disk is full"}] * 3]
    assert final_state(task)[0] == "failed"
    assert len(warnings(caplog)) == 1


def test_a_worker_waits_for_room(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    monkeypatch.setattr(worker, "RETRY_DELAY_S", 0.01)
    answers: Iterator[Exception | bool] = iter([FULL, FULL, DISK_FULL, DISK_FULL, True, True])
    left = 6

    def one_job() -> bool:
        nonlocal left
        left -= 1
        answer = next(answers)
        if isinstance(answer, Exception):
            raise answer
        return answer

    worker.work(one_job, lambda _: None, JobKinds([], worker="w"), lambda: left == 0, is_standby=False)
    reported = warnings(caplog)
    assert [("disk is full" in text, "No space left" in text) for text in reported] == [
        (True, False),
        (False, True),
        (False, False),
    ]
    assert "that is over" in reported[-1]


def test_the_supervisor_reports_a_full_disk_once(
    database: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    jobs = JobQueue(EventBus(), JobKinds([], worker="no.such.module"))
    supervisor = Supervisor(Settings(home=tmp_path), database, jobs)
    turns = 0

    def turn() -> None:
        nonlocal turns
        turns += 1
        if turns < 4:
            raise FULL

    monkeypatch.setattr(supervisor, "check_workers", turn)
    supervisor.watch(lambda _: turns > 4)
    assert len(warnings(caplog)) == 2, "that it came and that it went"
