"""Killed and cancelled workers, and invalid jobs: runs have the same result, and other jobs continue."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.jobs.exit_causes import TERMINATED
from app.jobs.locks import is_alive
from app.jobs.queue import PROGRESS_FRAMES
from app.jobs.supervisor import Supervisor
from tests.app.databases import new_database
from tests.app.jobs.office import FRAMES, LATEST, Office, make_office
from tests.app.jobs.same import assert_same
from tests.patience import within

SEED = int(os.environ.get("TSR_SEED", "0")) or random.randrange(10**6)


def kill(office: Office, run_id: str, frames: int, by: signal.Signals = signal.SIGKILL) -> int:
    """Kill the worker of a run once so many frames are done; returns the process."""

    def there() -> int | None:
        busy = office.job(run_id).state == "running" and office.run(run_id).frames_done >= frames
        return office.worker(run_id) if busy else None

    worker: int = office.wait(there)
    os.kill(worker, by)
    return worker


def kills(office: Office, run_id: str) -> int:
    """Number of kills from outside at one position."""
    return int(office.job(run_id).payload.get("ends", {}).get("killed", 0))


@pytest.mark.slow
def test_a_run_with_killed_workers_has_the_same_result(office: Office, undisturbed: Path) -> None:
    rng = random.Random(SEED)
    points = [rng.randrange(0, 20), rng.randrange(20, LATEST)]
    print(f"TSR_SEED={SEED} kills at {points}")
    office.open()
    run_id = office.start()
    workers, places = [], []
    for frames in points:
        workers.append(kill(office, run_id, frames))
        office.wait(lambda: office.job(run_id).token > len(workers))
        places.append(office.job(run_id).payload["died_at"])
    run = office.ended(run_id)
    assert len(set(workers)) == 2
    # The second death counts with the first unless the run progressed in between, which depends on timing.
    first, second = places
    assert second == first or second >= first + PROGRESS_FRAMES
    assert (kills(office, run_id), office.job(run_id).crashes) == (2 if second == first else 1, 0)
    assert (run.frames_done, run.frames_total) == (FRAMES, FRAMES)
    job = office.wait(lambda: j if (j := office.job(run_id)).state != "running" else None)  # reported after the run
    assert (job.state, job.token) == ("done", 3)
    assert_same(office.evidence(run_id), undisturbed)


@pytest.mark.slow
def test_a_cancelled_run_stops_and_can_resume(office: Office, undisturbed: Path) -> None:
    office.open()
    run_id = office.start()
    waiting = office.start()
    office.context.runs.cancel(waiting)  # not started: cancelled at once
    assert office.run(waiting).state == "cancelled"
    office.wait(lambda: office.run(run_id).frames_done > 3)
    began = time.monotonic()
    office.context.runs.cancel(run_id)
    office.ended(run_id, "cancelled")
    assert time.monotonic() - began < within(4)
    assert office.run(run_id).frames_done < FRAMES
    # The state is reported while the job is still held; its release follows.
    office.wait(lambda: not is_alive(office.context.settings.home, office.job(run_id).id))
    office.context.runs.resume(run_id)
    office.ended(run_id)
    assert_same(office.evidence(run_id), undisturbed)
    assert office.run(waiting).state == "cancelled"


@pytest.mark.slow
def test_a_server_returns_its_jobs_on_shutdown(office: Office, undisturbed: Path) -> None:
    office.open()
    run_id = office.start()
    office.wait(lambda: office.run(run_id).frames_done > 3)
    worker = office.worker(run_id)
    assert worker is not None
    office.close()
    job = office.job(run_id)
    assert (job.state, job.crashes, office.run(run_id).state) == ("queued", 0, "queued")
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)
    office.open()
    office.ended(run_id)
    assert_same(office.evidence(run_id), undisturbed)


@pytest.mark.slow
def test_a_job_that_keeps_dying_fails_and_the_others_continue(office: Office, tmp_path: Path) -> None:
    office.open()
    run_id = office.start()
    rubbish = tmp_path / "rubbish.mp4"
    rubbish.write_bytes(b"\x00\x00\x00\x18ftypisom\x00\x00\x02\x00isomiso2" + random.Random(1).randbytes(200_000))
    bad = office.context.videos.add_path(str(rubbish)).id
    for death in range(1, 4):
        kill(office, run_id, 0, signal.SIGSEGV)
        office.wait(lambda death=death: office.job(run_id).crashes == death)
    run = office.ended(run_id, "failed")
    assert run.error is not None
    assert "died 3 times before its first frame" in run.error
    assert run.error.count("\n") == 0
    view = office.wait(lambda: v if (v := office.context.videos.view(bad)).state != "importing" else None)
    assert view.state == "failed"
    assert view.error is not None
    assert "rubbish.mp4" in view.error
    assert "Traceback" not in view.error
    other = office.start(stop=2)
    assert office.ended(other).frames_done == 2
    with office.context.database.read() as session:
        reported = [
            event.data.get("error") for event in office.context.events.after(session, 0) if event.subject == run_id
        ]
    assert reported[-1] == run.error


@pytest.mark.slow
def test_on_postgresql_a_dead_worker_is_noticed_as_fast(cluster: str, tmp_path: Path) -> None:
    office = make_office(tmp_path / "home", database_url=new_database(cluster))
    try:
        office.open()
        run_id = office.start(stop=2)
        kill(office, run_id, 0)
        began = time.monotonic()
        office.wait(lambda: kills(office, run_id) == 1)
        assert time.monotonic() - began < within(3)
        assert office.ended(run_id).frames_done == 2
    finally:
        office.close()
        office.context.close()


@pytest.mark.slow
def test_a_hanging_worker_is_ended_when_its_run_is_cancelled(office: Office) -> None:
    office.supervising = Supervisor  # while a worker loads the engine, it holds no lock of the database
    office.open()
    run_id = office.start()
    worker = office.wait(lambda: office.worker(run_id) if office.job(run_id).state == "running" else None)
    os.kill(worker, signal.SIGSTOP)
    office.context.runs.cancel(run_id)
    office.ended(run_id, "cancelled")
    office.wait(lambda: not is_alive(office.context.settings.home, office.job(run_id).id))
    other = office.start(stop=2)
    assert office.ended(other).frames_done == 2


def test_a_hanging_worker_ends_itself_on_request() -> None:
    code = (
        "import time; from app.jobs.worker import _Termination; x = _Termination(0.5); print('here', flush=True)\n"
        "while True: time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as worker:
        assert worker.stdout is not None
        assert worker.stdout.readline() == "here\n"
        began = time.monotonic()
        worker.send_signal(signal.SIGTERM)
        assert worker.wait(within(20)) == TERMINATED, "no crash"
        assert time.monotonic() - began < within(3)


def test_a_hanging_worker_delays_no_shutdown_and_is_not_a_crash(office: Office) -> None:
    office.supervising = Supervisor  # while a worker loads the engine, it holds no lock of the database
    office.open()
    run_id = office.start(stop=2)
    worker = office.wait(lambda: office.worker(run_id) if office.job(run_id).state == "running" else None)
    os.kill(worker, signal.SIGSTOP)
    began = time.monotonic()
    office.close()
    assert time.monotonic() - began < within(2)
    job = office.job(run_id)
    assert (job.state, job.crashes) == ("queued", 0)
    assert office.run(run_id).state == "queued"
    office.open()
    assert office.ended(run_id).frames_done == 2
