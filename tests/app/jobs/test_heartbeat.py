"""Jobs of other machines on one PostgreSQL: the heartbeat decides whether a worker lives, not its progress."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.events import EventBus
from app.job_kinds import KINDS
from app.jobs import worker
from app.jobs.context import TaskContext
from app.jobs.heartbeat import heartbeat
from app.jobs.queue import JobQueue
from app.jobs.supervisor import Supervisor
from app.settings import Settings
from app.storage.database import Database
from app.storage.identity import lock_place
from app.storage.models import Job
from tests.app.databases import new_database
from tests.waiting import wait_until


@pytest.fixture
def shared(cluster: str) -> Iterator[Database]:
    """A database that several machines use."""
    database = Database(new_database(cluster))
    database.migrate()
    yield database
    database.close()


def claim_job(database: Database, place: str = "another machine:/data") -> Job:
    jobs = JobQueue(EventBus(), KINDS)
    with database.write() as session:
        job = jobs.claim(session, jobs.submit(session, "export", "s" * 32).id, place)
    assert job is not None
    return job


def reload_job(database: Database, job: Job) -> Job:
    with database.read() as session:
        return session.get_one(Job, job.id)


def test_a_worker_with_a_heartbeat_lives_without_progress(
    shared: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 0.0  # from the supervisor's view: a busy machine must not make workers look dead
    supervisor = Supervisor(Settings(home=tmp_path), shared, JobQueue(EventBus(), KINDS), clock=lambda: now)
    job = claim_job(shared)
    with heartbeat(shared, job, interval=0.05):
        for _ in range(3):
            seen = wait_until(lambda: one if (one := reload_job(shared, job)).heartbeat else None)
            assert not supervisor.is_dead(seen)
            now += 0.8 * supervisor.heartbeat_timeout
            wait_until(lambda seen=seen: reload_job(shared, job).heartbeat != seen.heartbeat)
    last = reload_job(shared, job)
    assert last.position is None
    for later, dead in ((0.0, False), (0.8, False), (1.6, True)):
        before, now = now, now + later * supervisor.heartbeat_timeout
        assert supervisor.is_dead(last) is dead
        now = before
    own = claim_job(shared, lock_place(tmp_path))
    assert supervisor.is_dead(reload_job(shared, own)), "of this machine the lock is asked"


def test_a_working_worker_has_a_heartbeat(shared: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    jobs = JobQueue(EventBus(), KINDS)
    with shared.write() as session:
        job = jobs.submit(session, "export", "s" * 32)
    monkeypatch.setattr(worker, "heartbeat", lambda database, job: heartbeat(database, job, interval=0.05))

    def work(task: TaskContext, _kinds: object) -> None:
        first = wait_until(lambda: reload_job(shared, task.job).heartbeat)
        wait_until(lambda: reload_job(shared, task.job).heartbeat != first)

    monkeypatch.setattr(worker, "execute", work)
    assert worker.do_next(Settings(home=tmp_path), shared, KINDS, jobs, lambda: False, lambda: [job.id])
    last = reload_job(shared, job).heartbeat
    time.sleep(0.3)
    assert reload_job(shared, job).heartbeat == last


def test_a_job_of_another_process_is_left_alone(shared: Database) -> None:
    job = claim_job(shared)
    with shared.write() as session:
        session.get_one(Job, job.id).token += 1
    with heartbeat(shared, job, interval=0.02):
        time.sleep(0.3)
    assert reload_job(shared, job).heartbeat is None


def test_on_sqlite_the_lock_suffices(tmp_path: Path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    database.migrate()
    before = threading.active_count()
    with heartbeat(database, claim_job(database), interval=0.02):
        assert threading.active_count() == before
    database.close()
