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
from tests.app.jobs.job_server import FRAMES, MAX_FRAME_IN_PROGRESS, JobServer, make_job_server
from tests.app.jobs.same_evidence import assert_same_evidence
from tests.waiting import time_limit, wait_until

SEED = int(os.environ.get("TSR_SEED", "0")) or random.randrange(10**6)


def kill(job_server: JobServer, run_id: str, frames: int, by: signal.Signals = signal.SIGKILL) -> int:
    """Kill the worker of a run once so many frames are done; returns the process."""

    def there() -> int | None:
        busy = job_server.job(run_id).state == "running" and job_server.run(run_id).frames_done >= frames
        return job_server.worker(run_id) if busy else None

    worker: int = wait_until(there)
    os.kill(worker, by)
    return worker


def count_kills(job_server: JobServer, run_id: str) -> int:
    """Number of kills from outside at one position."""
    return int(job_server.job(run_id).payload.get("ends", {}).get("killed", 0))


@pytest.mark.slow
def test_a_run_with_killed_workers_has_the_same_result(job_server: JobServer, reference_run: Path) -> None:
    rng = random.Random(SEED)
    points = [rng.randrange(0, 20), rng.randrange(20, MAX_FRAME_IN_PROGRESS)]
    print(f"TSR_SEED={SEED} kills at {points}")
    job_server.open()
    run_id = job_server.start()
    workers, places = [], []
    for frames in points:
        workers.append(kill(job_server, run_id, frames))
        wait_until(lambda: job_server.job(run_id).token > len(workers))
        places.append(job_server.job(run_id).payload["died_at"])
    run = job_server.ended(run_id)
    assert len(set(workers)) == 2
    # The second death counts with the first unless the run progressed in between, which depends on timing.
    first, second = places
    assert second == first or second >= first + PROGRESS_FRAMES
    assert (count_kills(job_server, run_id), job_server.job(run_id).crashes) == (2 if second == first else 1, 0)
    assert (run.frames_done, run.frames_total) == (FRAMES, FRAMES)
    job = wait_until(lambda: j if (j := job_server.job(run_id)).state != "running" else None)  # reported after the run
    assert (job.state, job.token) == ("done", 3)
    assert_same_evidence(job_server.evidence(run_id), reference_run)


@pytest.mark.slow
def test_a_cancelled_run_stops_and_can_resume(job_server: JobServer, reference_run: Path) -> None:
    job_server.open()
    run_id = job_server.start()
    waiting = job_server.start()
    job_server.context.runs.cancel(waiting)  # not started: cancelled at once
    assert job_server.run(waiting).state == "cancelled"
    wait_until(lambda: job_server.run(run_id).frames_done > 3)
    began = time.monotonic()
    job_server.context.runs.cancel(run_id)
    job_server.ended(run_id, "cancelled")
    assert time.monotonic() - began < time_limit(4)
    assert job_server.run(run_id).frames_done < FRAMES
    # The state is reported while the job is still held; its release follows.
    wait_until(lambda: not is_alive(job_server.context.settings.home, job_server.job(run_id).id))
    job_server.context.runs.resume(run_id)
    job_server.ended(run_id)
    assert_same_evidence(job_server.evidence(run_id), reference_run)
    assert job_server.run(waiting).state == "cancelled"


@pytest.mark.slow
def test_a_server_returns_its_jobs_on_shutdown(job_server: JobServer, reference_run: Path) -> None:
    job_server.open()
    run_id = job_server.start()
    wait_until(lambda: job_server.run(run_id).frames_done > 3)
    worker = job_server.worker(run_id)
    assert worker is not None
    job_server.close()
    job = job_server.job(run_id)
    assert (job.state, job.crashes, job_server.run(run_id).state) == ("queued", 0, "queued")
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)
    job_server.open()
    job_server.ended(run_id)
    assert_same_evidence(job_server.evidence(run_id), reference_run)


@pytest.mark.slow
def test_a_job_that_keeps_dying_fails_and_the_others_continue(job_server: JobServer, tmp_path: Path) -> None:
    job_server.open()
    run_id = job_server.start()
    rubbish = tmp_path / "rubbish.mp4"
    rubbish.write_bytes(b"\x00\x00\x00\x18ftypisom\x00\x00\x02\x00isomiso2" + random.Random(1).randbytes(200_000))
    bad = job_server.context.videos.add_path(str(rubbish)).id
    for death in range(1, 4):
        kill(job_server, run_id, 0, signal.SIGSEGV)
        wait_until(lambda death=death: job_server.job(run_id).crashes == death)
    run = job_server.ended(run_id, "failed")
    assert run.error is not None
    assert "died 3 times before its first frame" in run.error
    assert run.error.count("\n") == 0
    view = wait_until(lambda: v if (v := job_server.context.videos.view(bad)).state != "importing" else None)
    assert view.state == "failed"
    assert view.error is not None
    assert "rubbish.mp4" in view.error
    assert "Traceback" not in view.error
    other = job_server.start(stop=2)
    assert job_server.ended(other).frames_done == 2
    with job_server.context.database.read() as session:
        reported = [
            event.data.get("error") for event in job_server.context.events.after(session, 0) if event.subject == run_id
        ]
    assert reported[-1] == run.error


@pytest.mark.slow
def test_on_postgresql_a_dead_worker_is_noticed_as_fast(cluster: str, tmp_path: Path) -> None:
    job_server = make_job_server(tmp_path / "home", database_url=new_database(cluster))
    try:
        job_server.open()
        run_id = job_server.start(stop=2)
        kill(job_server, run_id, 0)
        began = time.monotonic()
        wait_until(lambda: count_kills(job_server, run_id) == 1)
        assert time.monotonic() - began < time_limit(3)
        assert job_server.ended(run_id).frames_done == 2
    finally:
        job_server.close()
        job_server.context.close()


@pytest.mark.slow
def test_a_hanging_worker_is_ended_when_its_run_is_cancelled(job_server: JobServer) -> None:
    job_server.supervising = Supervisor  # while a worker loads the engine, it holds no lock of the database
    job_server.open()
    run_id = job_server.start()
    worker = wait_until(lambda: job_server.worker(run_id) if job_server.job(run_id).state == "running" else None)
    os.kill(worker, signal.SIGSTOP)
    job_server.context.runs.cancel(run_id)
    job_server.ended(run_id, "cancelled")
    wait_until(lambda: not is_alive(job_server.context.settings.home, job_server.job(run_id).id))
    other = job_server.start(stop=2)
    assert job_server.ended(other).frames_done == 2


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
        assert worker.wait(time_limit(20)) == TERMINATED, "no crash"
        assert time.monotonic() - began < time_limit(3)


def test_a_hanging_worker_delays_no_shutdown_and_is_not_a_crash(job_server: JobServer) -> None:
    job_server.supervising = Supervisor  # while a worker loads the engine, it holds no lock of the database
    job_server.open()
    run_id = job_server.start(stop=2)
    worker = wait_until(lambda: job_server.worker(run_id) if job_server.job(run_id).state == "running" else None)
    os.kill(worker, signal.SIGSTOP)
    began = time.monotonic()
    job_server.close()
    assert time.monotonic() - began < time_limit(2)
    job = job_server.job(run_id)
    assert (job.state, job.crashes) == ("queued", 0)
    assert job_server.run(run_id).state == "queued"
    job_server.open()
    assert job_server.ended(run_id).frames_done == 2
