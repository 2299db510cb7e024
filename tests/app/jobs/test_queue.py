"""The queue's rules, on both databases: claims, fences, deaths."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest

from app.events import EventBus
from app.job_kinds import KINDS
from app.jobs.context import TaskContext
from app.jobs.outcome import end_stopped_task, report_failure
from app.jobs.queue import MAX_CRASHES, Fenced, JobQueue
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job, Run, Video

VIDEO, RUN = "f" * 64, "a" * 32


@pytest.fixture
def queue(database: Database) -> JobQueue:
    with database.write() as session:
        session.add(Video(id=VIDEO, name="v", path="/v", size=1, warnings=[]))
        session.flush()
        session.add(Run(id=RUN, video_id=VIDEO, state="queued", parameters={}, models={}, summary={}))
    return JobQueue(EventBus(), KINDS)


def submit(database: Database, queue: JobQueue, priority: int = 0) -> str:
    with database.write() as session:
        return queue.submit(session, "track", RUN, priority=priority).id


def claim(database: Database, queue: JobQueue, job_id: str) -> TaskContext:
    with database.write() as session:
        job = queue.claim(session, job_id)
    assert job is not None
    return TaskContext(Settings(), database, queue.events, queue, job, lambda: False)


def state(database: Database, job_id: str) -> tuple[str, int, int]:
    with database.read() as session:
        job = session.get_one(Job, job_id)
        return job.state, job.token, job.crashes


def test_first_come_first_served_but_for_priority(database: Database, queue: JobQueue) -> None:
    first, second, urgent = submit(database, queue), submit(database, queue), submit(database, queue, 10)
    with database.read() as session:
        assert list(queue.waiting_ids(session)) == [urgent, first, second]


def test_a_job_is_claimed_once(database: Database, queue: JobQueue) -> None:
    job = submit(database, queue)

    def grab(_: int) -> bool:
        with database.write() as session:
            return queue.claim(session, job) is not None

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(grab, range(16))) == 1
    assert state(database, job) == ("running", 1, 0)


def test_an_old_token_cannot_write(database: Database, queue: JobQueue) -> None:
    job = submit(database, queue)
    old = claim(database, queue, job)
    with database.write() as session:
        assert queue.requeue_dead(session, job, old.job.token) is None  # declared dead, but it only slept
    new = claim(database, queue, job)

    def late() -> None:
        with old.write() as session:
            session.get_one(Run, RUN).state = "complete"

    with pytest.raises(Fenced):
        late()
    report_failure(old, "too late")
    end_stopped_task(old)
    with pytest.raises(Fenced), database.write() as session:
        queue.finish(session, job, old.job.token, "done")
    with pytest.raises(Fenced), database.write() as session:
        queue.requeue_dead(session, job, old.job.token)
    with database.read() as session:
        assert session.get_one(Run, RUN).state == "queued"
        assert queue.events.newest(session) == 0
    assert state(database, job) == ("running", 2, 1)
    assert old.is_cancelled(), "it is asked to stop, too"
    with new.write() as session:
        session.get_one(Run, RUN).state = "running"
    with database.write() as session:
        queue.finish(session, job, new.job.token, "done")
    assert state(database, job)[0] == "done"
    with pytest.raises(Fenced), database.write() as session:
        queue.requeue_dead(session, job, new.job.token)
    with pytest.raises(Fenced), new.write():
        pass


def report_death(database: Database, queue: JobQueue, job: str, position: int | None) -> Job | None:
    task = claim(database, queue, job)
    if position is not None:
        with task.write() as session:
            task.record_progress(session, position)
    with database.write() as session:
        return queue.requeue_dead(session, job, task.job.token)


@pytest.mark.parametrize("places", [[None] * 3, [50, 50, 50], [50, 47, 52], [31, 33, 30], [50, None, 51]])
def test_a_job_that_keeps_dying_at_one_position_fails(
    database: Database, queue: JobQueue, places: list[int | None]
) -> None:
    """Progress is stored only a few times a second, so one position is a range of numbers."""
    job = submit(database, queue)
    ended = [report_death(database, queue, job, place) for place in places]
    assert [one is None for one in ended] == [True, True, False]
    last = ended[-1]
    assert last is not None
    assert last.state == "failed"
    assert f"died {MAX_CRASHES} times" in (last.error or "")
    assert state(database, job)[0] == "failed"


def test_a_job_that_dies_but_progresses_is_retried(database: Database, queue: JobQueue) -> None:
    job = submit(database, queue)
    for place in range(0, 1000, 100):
        assert report_death(database, queue, job, place) is None
    assert state(database, job) == ("queued", 10, 1)


def test_a_cancelled_job_that_dies_is_cancelled(database: Database, queue: JobQueue) -> None:
    job = submit(database, queue)
    task = claim(database, queue, job)
    with database.write() as session:
        assert [one.state for one in queue.cancel(session, RUN)] == ["running"]
    with database.write() as session:
        ended = queue.requeue_dead(session, job, task.job.token)
    assert ended is not None
    assert ended.state == "cancelled"
