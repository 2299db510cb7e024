"""A server that is killed and started again."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import requests

from app.jobs.locks import holder_pid
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Job
from tests.app.jobs.job_server import FRAMES, KNOWN_FOCUS
from tests.app.jobs.same_evidence import assert_same_evidence
from tests.app.toy_server import SECRET
from tests.forked_program import ForkedProgram
from tests.waiting import time_limit


class ReviewProcess:
    """A running ``tsr review``."""

    def __init__(self, home: Path) -> None:
        self.home = home
        environment = {**os.environ, "TSR_TOKEN": SECRET, "TSR_SAMPLE": "false"}
        words = ["review", "--no-browser", "--home", str(home), "--port", "0"]
        self.process = ForkedProgram("app.cli.main:run", words, environment, stderr=subprocess.DEVNULL)
        self.url = self._address()
        self.session = requests.Session()
        self.session.headers["Authorization"] = f"Bearer {SECRET}"

    def _address(self) -> str:
        deadline = time.monotonic() + time_limit(30)
        while True:
            assert self.process.poll() is None, "the server has ended at once"
            assert time.monotonic() < deadline, "the server does not start"
            try:
                note = json.loads((self.home / "server.json").read_text())
            except (OSError, ValueError):
                note = {}
            if note.get("pid") == self.process.pid:
                return str(note["base"])
            time.sleep(0.05)

    def call(self, method: str, path: str, **options: Any) -> Any:
        """Send a request; waits until the server listens."""
        deadline = time.monotonic() + time_limit(20)
        while True:
            try:
                answer = self.session.request(method, self.url + path, timeout=10, **options)
            except requests.ConnectionError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.05)
                continue
            assert answer.status_code < 300, answer.text
            return answer.json()

    def wait(self, run_id: str, what: Callable[[Any], bool]) -> Any:
        """Wait until a run has a property."""
        deadline = time.monotonic() + 240
        while not what(run := self.call("GET", f"/api/runs/{run_id}")):
            assert time.monotonic() < deadline, run
            time.sleep(0.1)
        return run

    def worker(self, run_id: str) -> int:
        """The process that works on a run."""
        database = Database(Settings(home=self.home).database)
        with database.read() as session:
            job = session.query(Job).filter(Job.subject == run_id).one()
        database.close()
        found = holder_pid(self.home, job.id)
        assert found is not None
        return found


@contextmanager
def reviewing(home: Path) -> Iterator[ReviewProcess]:
    """``tsr review``, ended by Ctrl-C if it still runs."""
    made = ReviewProcess(home)
    try:
        yield made
    finally:
        if made.process.poll() is None:
            made.process.send_signal(signal.SIGINT)
        made.process.wait(time_limit(20))
        made.session.close()


def is_alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@pytest.mark.slow
def test_kill_9_of_the_server_ends_its_worker_and_the_next_one_resumes(
    imported_home: Path, reference_run: Path, tmp_path: Path
) -> None:
    home = tmp_path / "home"
    shutil.copytree(imported_home, home)
    with reviewing(home) as first:
        video = first.call("GET", "/api/videos")["videos"][0]["id"]
        wanted = {"stop": FRAMES, "parameters": KNOWN_FOCUS}
        run = first.call("POST", f"/api/videos/{video}/runs", json=wanted)["id"]
        first.wait(run, lambda r: r["frames_done"] >= 5)
        worker = first.worker(run)
        os.kill(first.process.pid, signal.SIGKILL)
        first.process.wait()
        deadline = time.monotonic() + time_limit(6)
        while is_alive(worker):
            assert time.monotonic() < deadline, "the worker outlives its server"
            time.sleep(0.05)
    with reviewing(home) as second:
        done = second.wait(run, lambda r: r["state"] not in ("queued", "running"))
        assert (done["state"], done["frames_done"]) == ("complete", FRAMES), done
        began = time.monotonic()
        second.process.send_signal(signal.SIGINT)
        assert second.process.wait(time_limit(10)) in (0, 128 + signal.SIGINT)
        assert time.monotonic() - began < time_limit(6)
    assert_same_evidence(home / "runs" / run, reference_run)
