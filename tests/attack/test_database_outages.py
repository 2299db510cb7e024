"""PostgreSQL restarts: requests get a retry answer, jobs return to the queue, and nothing counts as a crash."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import make_url, text
from sqlalchemy.exc import DBAPIError, OperationalError

from app.errors import Busy, StorageFull
from app.events import EventBus
from app.jobs import worker
from app.jobs.context import TaskContext
from app.jobs.kinds import JobKinds
from app.jobs.queue import JobQueue
from app.jobs.tasks import TaskKind
from app.settings import Settings
from app.storage import database as storage
from app.storage.database import Database, storage_failure
from app.storage.models import Job
from tests.app.databases import Cluster, new_database, running_cluster
from tests.app.toy_server import Server
from tests.attack.dropped_packets import DroppingProxy


@pytest.fixture(scope="module")
def own_cluster() -> Iterator[Cluster]:
    """A separate PostgreSQL that a test may stop."""
    with running_cluster() as made:
        yield made


@pytest.fixture
def served(own_cluster: Cluster, tmp_path: Path) -> Iterator[Server]:
    server = Server(tmp_path / "home", database_url=new_database(own_cluster.url))
    with server.client:
        yield server


@pytest.mark.parametrize("mode", ["fast", "immediate"])
def test_requests_are_answered_with_retry(served: Server, own_cluster: Cluster, mode: str) -> None:
    client = served.client
    assert client.get("/api/videos").status_code == 200
    own_cluster.stop(mode)
    try:
        for answer in (
            client.get("/api/videos"),
            client.get("/api/videos"),
            client.patch(f"/api/runs/{'0' * 32}", json={"name": "x"}),
            client.post(f"/api/runs/{'0' * 32}/cancel"),
        ):
            assert (answer.status_code, answer.json()["error"]["code"]) == (503, "database_busy"), answer.text
            assert int(answer.headers["retry-after"]) > 0
    finally:
        own_cluster.start()
    assert client.get("/api/videos").json() == {"videos": []}
    assert client.patch(f"/api/runs/{'0' * 32}", json={"name": "x"}).status_code == 404


def test_a_lost_connection_is_an_outage(own_cluster: Cluster) -> None:
    database = Database(new_database(own_cluster.url))
    with pytest.raises(DBAPIError) as cut, database.read() as session:
        session.execute(text("SELECT pg_terminate_backend(pg_backend_pid())"))
    assert isinstance(storage_failure(cut.value), Busy)
    database.close()


def test_a_network_that_drops_packets_is_an_outage(own_cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    """The query fails when its packets are not acknowledged in time, and the next one waits for no answer either."""
    monkeypatch.setattr(
        storage, "NETWORK_OPTIONS", {**storage.NETWORK_OPTIONS, "connect_timeout": 2, "tcp_user_timeout": 2000}
    )
    folder = make_url(own_cluster.url).query["host"]
    with DroppingProxy(f"{folder}/.s.PGSQL.5432") as proxy:
        database = Database(f"postgresql+psycopg://tsr@127.0.0.1:{proxy.port}/postgres")
        with database.read() as session:
            session.execute(text("SELECT 1"))
        proxy.drop()
        for _ in range(2):
            began = time.monotonic()
            with pytest.raises(OperationalError) as failed, database.read() as session:
                session.execute(text("SELECT 1"))
            assert time.monotonic() - began < 20
            assert isinstance(storage_failure(failed.value), Busy)
        proxy.restore()
        with database.read() as session:
            assert session.execute(text("SELECT 1")).scalar() == 1
        database.close()


@pytest.mark.parametrize(
    ("state", "failure"),
    [
        ("08006", Busy),
        ("57P01", Busy),
        ("57P03", Busy),
        ("53300", Busy),
        ("40P01", Busy),
        ("53100", StorageFull),
        ("25006", StorageFull),
        ("23505", type(None)),
        ("42P01", type(None)),
    ],
)
def test_outages_are_recognised_in_every_server_language(state: str, failure: type) -> None:
    said = type("Foreign", (Exception,), {"sqlstate": state})("Der Server faehrt gerade herunter")
    assert isinstance(storage_failure(OperationalError("SELECT 1", {}, said)), failure)


def claimed(database: Database, home: Path, kinds: JobKinds[TaskKind]) -> TaskContext:
    jobs = JobQueue(EventBus(), kinds)
    with database.write() as session:
        job = jobs.claim(session, jobs.submit(session, "bake", "s" * 32).id)
    assert job is not None
    return TaskContext(Settings(home=home), database, jobs.events, jobs, job, leaving=lambda: False)


def test_a_job_that_loses_the_database_is_requeued(
    own_cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It waits for the database, then for the next worker; nothing counts as a failure."""
    monkeypatch.setattr(worker, "RETRY_DELAY_S", 0.05)
    database = Database(new_database(own_cluster.url))
    database.migrate()
    stopped = threading.Event()

    def work(task: TaskContext) -> None:
        stopped.wait()
        with task.write():
            pass

    kind = TaskKind(name="bake", lane="short", load=lambda: work, on_failed=lambda *_: None)
    kinds = JobKinds([kind], worker="no.such.module")
    task = claimed(database, tmp_path, kinds)
    thread = threading.Thread(target=worker.execute, args=(task, kinds))
    thread.start()
    own_cluster.stop()
    stopped.set()
    time.sleep(0.3)
    assert thread.is_alive(), "it cannot say so yet"
    own_cluster.start()
    thread.join(60)
    assert not thread.is_alive()
    with database.read() as session:
        job = session.get_one(Job, task.job.id)
        assert (job.state, job.crashes, job.error) == ("queued", 0, None)
        assert "ends" not in job.payload
    database.close()


def test_a_missed_heartbeat_during_an_outage_is_excused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from app.jobs.supervisor import Supervisor

    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    database.migrate()
    database.is_sqlite = False  # another machine's lock is not visible here
    now = 0.0
    jobs = JobQueue(EventBus(), JobKinds([], worker="no"))
    supervisor = Supervisor(Settings(home=tmp_path), database, jobs, clock=lambda: now)
    job = Job(id="j" * 32, token=1, payload={"place": "elsewhere"}, heartbeat=None)
    assert not supervisor.is_dead(job)
    turns = iter([OperationalError("SELECT", {}, Exception("away")), None])

    def turn() -> None:
        nonlocal now
        now += 2 * supervisor.heartbeat_timeout
        if (error := next(turns)) is not None:
            raise error

    monkeypatch.setattr(supervisor, "check_workers", turn)
    waits = iter([False, False, False, True])
    supervisor.watch(lambda _: next(waits))
    assert not supervisor.is_dead(job)
    now += 2 * supervisor.heartbeat_timeout
    assert supervisor.is_dead(job)
    database.close()
