"""Workers that are killed from outside, die with their server, run out of memory, or crash on a file.

Only a crash blames the file.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.events import EventBus
from app.jobs import exit_causes
from app.jobs import supervisor as supervising
from app.jobs.exit_causes import TERMINATED, count_oom_kills, exit_cause
from app.jobs.locks import holder_pid
from app.jobs.queue import MAX_CRASHES, JobQueue
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job
from tests.app.jobs.job_server import ForkingSupervisor
from tests.attack.dying_worker import KINDS
from tests.waiting import wait_until

pytestmark = pytest.mark.slow


class DyingWorkers(ForkingSupervisor):
    """A supervisor of workers of ``dying_worker``."""

    program = "tests.attack.dying_worker:do_jobs"


class WorkerHome:
    """A data folder with a queue, and a supervisor that starts workers of ``dying_worker``."""

    def __init__(self, home: Path, executor: str = "local") -> None:
        self.settings = Settings(home=home, roots=(home,), sample=False, workers=1, executor=executor)
        self.database = Database(self.settings.database)
        self.database.migrate()
        self.jobs = JobQueue(EventBus(), KINDS)
        self.supervisor = DyingWorkers(self.settings, self.database, self.jobs)

    def submit(self, kind: str, **payload: Any) -> str:
        with self.database.write() as session:
            return self.jobs.submit(session, kind, "s" * 32, payload).id

    def job(self, job_id: str) -> Job:
        with self.database.read() as session:
            return session.get_one(Job, job_id)

    def ended(self, job_id: str) -> Job:
        found: Job = wait_until(lambda: job if (job := self.job(job_id)).state not in ("queued", "running") else None)
        return found


@pytest.fixture
def executor() -> str:
    """Where runs are computed."""
    return "local"


@pytest.fixture
def home(tmp_path: Path, executor: str) -> Iterator[WorkerHome]:
    made = WorkerHome(tmp_path, executor)
    yield made
    made.supervisor.stop()
    made.database.close()


def test_a_job_killed_three_times_from_outside_continues(home: WorkerHome, tmp_path: Path) -> None:
    home.supervisor.start()
    job = home.submit("wait", until=str(tmp_path / "now"))
    for death in range(1, MAX_CRASHES + 1):
        worker = wait_until(lambda: holder_pid(tmp_path, job) if home.job(job).state == "running" else None)
        os.kill(worker, signal.SIGKILL)
        wait_until(lambda death=death: home.job(job).payload.get("ends", {}).get("killed") == death)
    (tmp_path / "now").touch()
    ended = home.ended(job)
    assert (ended.state, ended.error, ended.crashes) == ("done", None, 0)


def test_a_job_that_crashes_on_its_file_fails_with_the_position(home: WorkerHome) -> None:
    home.supervisor.start()
    ended = home.ended(home.submit("die", signal="SIGSEGV", at=17))
    assert ended.state == "failed"
    assert ended.error == f"The engine died {MAX_CRASHES} times at frame 17. The file may be damaged there."


@pytest.mark.parametrize("executor", ["ray"])
def test_the_loss_of_a_cluster_does_not_blame_the_file(home: WorkerHome) -> None:
    """Ray ends a process with exit code 1 if its cluster has not answered for a minute."""
    home.supervisor.start()
    job = home.submit("leave", code=1)
    wait_until(lambda: home.job(job).payload.get("ends", {}).get("killed", 0) > MAX_CRASHES)
    assert (home.job(job).crashes, home.job(job).error) == (0, None)


def test_running_out_of_memory_is_reported(home: WorkerHome, monkeypatch: pytest.MonkeyPatch) -> None:
    kills = iter(range(10**6))
    monkeypatch.setattr(supervising, "count_oom_kills", lambda: next(kills))
    home.supervisor.start()
    ended = home.ended(home.submit("die", signal="SIGKILL", at=17))
    assert ended.state == "failed"
    assert ended.error is not None
    assert ended.error.startswith("The machine had no memory left 3 times at frame 17.")
    assert "damaged" not in ended.error


def test_a_worker_killed_with_its_server_is_not_a_crash(home: WorkerHome, tmp_path: Path) -> None:
    """The next server finds the job and the note of another server's process."""
    job_id = home.submit("die", signal="SIGSEGV", at=17)
    for death in range(1, MAX_CRASHES + 2):
        with home.database.write() as session:
            job = home.jobs.claim(session, job_id)
        assert job is not None
        (tmp_path / "locks").mkdir(exist_ok=True)
        (tmp_path / "locks" / f"{job_id}.lock").write_text("4194303")
        home.supervisor.requeue_dead(job, home.supervisor.cause_of_death(job))
        after = home.job(job_id)
        assert (after.state, after.crashes, after.payload["ends"]) == ("queued", 0, {"killed": death})


@pytest.mark.parametrize(
    ("code", "starving", "cause"),
    [
        (-signal.SIGKILL, False, "killed"),
        (-signal.SIGKILL, True, "starved"),
        (-signal.SIGTERM, False, "killed"),
        (TERMINATED, False, "killed"),
        (0, True, "killed"),
        (-signal.SIGSEGV, True, "crashed"),
        (-signal.SIGABRT, False, "crashed"),
        (-signal.SIGFPE, False, "crashed"),
        (1, False, "crashed"),
    ],
)
def test_exit_codes(code: int, starving: bool, cause: str) -> None:
    assert exit_cause(code, starving) == cause


@pytest.mark.parametrize(
    ("groups", "files", "count"),
    [
        ("0::/user/tsr\n", {"sys/user/tsr/memory.events": "low 0\noom 3\noom_kill 2\noom_group_kill 0\n"}, 2),
        ("0::/user/tsr\n", {"sys/memory.events": "oom_kill 4\n"}, 4),
        ("4:cpu:/a\n3:memory:/a\n0::/\n", {"sys/memory/a/memory.oom_control": "under_oom 0\noom_kill 5\n"}, 5),
        ("0::/\n", {"proc/vmstat": "nr_free_pages 9\noom_kill 7\n"}, 7),
        ("", {}, 0),
    ],
)
def test_count_of_processes_killed_for_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, groups: str, files: dict[str, str], count: int
) -> None:
    for name, content in {"proc/self/cgroup": groups, **files}.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content)
    monkeypatch.setattr(exit_causes, "PROC", tmp_path / "proc")
    monkeypatch.setattr(exit_causes, "CGROUPS", tmp_path / "sys")
    assert count_oom_kills() == count
