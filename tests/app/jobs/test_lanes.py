"""Two lanes: interactive jobs run beside long ones, and a death in one lane does not affect the other."""

from __future__ import annotations

import os
import shutil
import signal
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.orm import Session

from app.context import Context, build_context
from app.events import EventBus
from app.exchange.export import ExportRequest
from app.job_kinds import KINDS
from app.jobs.locks import JobLock, holder_pid
from app.jobs.queue import JobQueue
from app.jobs.supervisor import Supervisor
from app.outputs.folders import output_folder
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job, Output, Run
from tests.app.jobs.job_server import ForkingSupervisor
from tests.app.toy_server import SECRET
from tests.waiting import wait_until
from tsr_engine.io.digest import file_sha256

PICTURES = 150


@pytest.fixture
def context(drive: Path, tmp_path: Path) -> Iterator[Context]:
    """A server's parts, with a supervisor of one long worker."""
    home = tmp_path / "home"
    shutil.copytree(drive, home)
    made = build_context(Settings(home=home, roots=(home,), sample=False, workers=1, token=SECRET))
    supervisor = ForkingSupervisor(made.settings, made.database, made.jobs)
    supervisor.start()
    yield made
    supervisor.stop()
    made.close()


def row(context: Context, kind: Any, identity: str) -> Any:
    """One row, freshly read."""
    with context.database.read() as session:
        return session.get_one(kind, identity)


def job_of(context: Context, subject: str) -> Job:
    """The job of a subject."""
    with context.database.read() as session:
        return session.query(Job).filter(Job.subject == subject).one()


def only_run(context: Context) -> Run:
    """The only run."""
    with context.database.read() as session:
        return session.query(Run).filter(Run.state == "complete").one()


def wait_for_export(context: Context, output_id: str) -> Output:
    """Wait for an export."""
    found: Output = wait_until(
        lambda: a if (a := row(context, Output, output_id)).state not in ("queued", "running") else None
    )
    return found


def pictures_of(run: Run) -> ExportRequest:
    """An export that takes a while."""
    return ExportRequest(runs=[run.id], format="cvat-images", pictures="all", stop=PICTURES)


def test_each_kind_has_a_lane(tmp_path: Path) -> None:
    short = KINDS.in_lane("short")
    assert {KINDS.lane_of(kind) for kind in ("track", "retrain", "something new")} == {"long"}
    assert set(short) == {"follow", "whatif", "export", "recording", "bundle"}
    assert KINDS.in_lane("imports") == ["import"]
    assert KINDS.in_lane("scenes") == ["scene"]
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    database.migrate()
    jobs = JobQueue(EventBus(), KINDS)
    with database.write() as session:
        made = {kind: jobs.submit(session, kind, kind).id for kind in ("track", "import", *short)}
        urgent = jobs.submit(session, "whatif", "w", priority=9).id
    with database.read() as session:
        assert jobs.waiting_ids(session, "long") == [made["track"]]
        assert jobs.waiting_ids(session, "imports") == [made["import"]]
        assert jobs.waiting_ids(session, "short") == [urgent, *(made[kind] for kind in short)]
        assert len(jobs.waiting_ids(session)) == len(made) + 1
    database.close()


def test_two_imports_do_not_delay_a_what_if_or_an_export(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    home = tmp_path / "home"
    made = build_context(Settings(home=home, roots=(tmp_path,), sample=False, workers=1, token=SECRET))
    supervisor = Supervisor(made.settings, made.database, made.jobs)
    started: list[str] = []

    class Running:
        def poll(self) -> None:
            """Check that the job makes progress."""

    def start(lane: str, *_: str) -> Running:
        started.append(lane)
        return Running()

    monkeypatch.setattr(supervisor, "spawn", start)

    def submit(kind: str, subject: str) -> JobLock:
        with made.database.write() as session:
            job = made.jobs.submit(session, kind, subject)
        supervisor.check_workers()
        lock = JobLock(home, job.id)
        assert lock.acquire()
        with made.database.write() as session:
            assert made.jobs.claim(session, job.id) is not None
        return lock

    locks = [submit("import", "a"), submit("import", "b"), submit("export", "c"), submit("whatif", "d")]
    assert started == ["imports", "imports", "short", "short"]
    for lock in locks:
        lock.release()
    made.close()


@pytest.mark.slow
def test_a_job_that_ends_during_a_check_stays_ended(drive: Path, tmp_path: Path) -> None:
    """The supervisor read a running job; before it checked the worker, both had ended normally."""
    shutil.copytree(drive, tmp_path / "home")
    made = build_context(Settings(home=tmp_path / "home", roots=(tmp_path,), sample=False, workers=0, token=SECRET))
    run = only_run(made)
    with made.database.write() as session:
        job = made.jobs.claim(session, made.jobs.submit(session, "track", run.id).id)
    assert job is not None

    class Late(JobQueue):
        def running_jobs(self, session: Session) -> list[Job]:
            return [job]

    with made.database.write() as session:
        made.jobs.finish(session, job.id, job.token, "done")
    Supervisor(made.settings, made.database, Late(made.events, KINDS)).check_workers()
    assert (row(made, Run, run.id).state, job_of(made, run.id).state) == ("complete", "done")
    made.close()


def test_an_export_runs_beside_a_run_and_survives_the_death_of_its_worker(context: Context) -> None:
    run = only_run(context)
    long = context.runs.start(run.video_id)
    second = context.runs.start(run.video_id)
    wait_until(lambda: row(context, Run, long.id).state == "running")
    output = context.exports.start(pictures_of(run))
    folder = output_folder(context.settings.home, output.id)

    def half_made() -> int | None:
        if row(context, Output, output.id).state != "running":
            return None
        busy = any(path.is_file() for path in folder.glob(".export.zip.*/**/*"))
        return holder_pid(context.settings.home, job_of(context, output.id).id) if busy else None

    os.kill(wait_until(half_made), signal.SIGKILL)
    assert not (folder / "export.zip").exists()
    wait_until(lambda: job_of(context, output.id).payload.get("ends") == {"killed": 1})
    found = wait_for_export(context, output.id)
    assert found.state == "complete", found.error
    assert row(context, Run, long.id).state == "running", "the run was not held up, and did not hold it up"
    assert row(context, Run, second.id).state == "queued", "long work still goes one after the other"
    context.runs.cancel(second.id)
    context.runs.cancel(long.id)
    assert [path.name for path in folder.iterdir()] == ["export.zip"], "nothing is left of the first attempt"
    assert file_sha256(folder / "export.zip") == found.sha256
    with zipfile.ZipFile(folder / "export.zip") as archive:
        assert archive.testzip() is None
        assert sum(name.endswith((".jpg", ".png")) for name in archive.namelist()) == PICTURES
    wait_until(lambda: row(context, Run, long.id).state == "cancelled")


@pytest.mark.slow
def test_an_export_is_cancelled_and_leaves_nothing(context: Context) -> None:
    output = context.exports.start(pictures_of(only_run(context)))
    wait_until(lambda: row(context, Output, output.id).state == "running")
    context.outputs.cancel(output.id)
    assert wait_for_export(context, output.id).state == "cancelled"
    wait_until(lambda: not output_folder(context.settings.home, output.id).exists())
