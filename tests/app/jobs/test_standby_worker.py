"""The standby worker that runs while a page is open."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest

from app.context import Context, build_context
from app.exchange.export import ExportRequest
from app.jobs.locks import holder_pid
from app.jobs.supervisor import Supervisor
from app.jobs.worker import run_preparation
from app.settings import Settings
from app.storage.models import Job, Output, Run
from tests.app.toy_server import SECRET
from tests.waiting import wait_until

wait = partial(wait_until, seconds=120.0)

pytestmark = pytest.mark.slow


@dataclass
class Standby:
    """A data folder with a supervisor, and a page that is open or not."""

    context: Context
    supervisor: Supervisor
    open: bool = True

    def process(self) -> int | None:
        """The standby process."""
        process = self.supervisor.standby_pid
        return process if process is not None and "stay" in command_line(process) else None


@pytest.fixture
def standby(drive: Path, tmp_path: Path) -> Iterator[Standby]:
    """A supervisor with an open page, whose standby worker ends at once when the page closes."""
    home = shutil.copytree(drive, tmp_path / "home")
    context = build_context(Settings(home=home, roots=(home,), sample=False, workers=1, token=SECRET))
    supervisor = Supervisor(context.settings, context.database, context.jobs, is_page_open=lambda: made.open)
    supervisor.linger, supervisor.restart_delay = 0.3, 0.1
    made = Standby(context, supervisor)
    made.supervisor.start()
    yield made
    made.supervisor.stop()
    context.close()


def command_line(process: int) -> str:
    try:
        return Path(f"/proc/{process}/cmdline").read_text().replace("\0", " ")
    except OSError:
        return ""


def test_the_standby_worker_runs_jobs_and_stays(standby: Standby) -> None:
    process = wait(standby.process)
    with standby.context.database.read() as session:
        run = session.query(Run).filter(Run.state == "complete").one()
    made = standby.context.exports.start(ExportRequest(runs=[run.id], format="tracks-json"))
    seen: set[int | None] = set()

    def state() -> str | None:
        with standby.context.database.read() as session:
            job = session.query(Job).filter(Job.subject == made.id).one()
            seen.add(holder_pid(standby.context.settings.home, job.id))
            found = session.get_one(Output, made.id).state
            return found if found not in ("queued", "running") else None

    assert wait(state) == "complete"
    assert seen <= {process, None}
    assert standby.process() == process


def test_the_standby_worker_ends_with_the_last_page(standby: Standby) -> None:
    process = wait(standby.process)
    standby.open = False
    wait(lambda: not command_line(process))
    time.sleep(0.6)  # two turns of the supervisor
    assert standby.process() is None
    standby.open = True
    assert wait(standby.process) != process


def test_a_dead_standby_worker_is_replaced(standby: Standby) -> None:
    process = wait(standby.process)
    os.kill(process, signal.SIGKILL)
    wait(lambda: standby.process() not in (None, process))


def test_the_standby_worker_loads_modules_of_jobs() -> None:
    code = (
        "import sys, app.jobs.tasks as r; from app.job_kinds import KINDS\n"
        "needed = {'rerun', 'tsr_engine.runs.replay', 'app.exchange.task'}\n"
        "assert not needed & set(sys.modules)\n"
        "for step in r.preparations(KINDS): step()\n"
        "assert needed <= set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_failed_load_ends_only_the_preparation() -> None:
    def fail() -> None:
        raise ImportError("no such thing")

    assert not run_preparation(fail)
    assert run_preparation(lambda: None)


def test_bare_evidence_is_named_without_loading_a_database() -> None:
    code = "import sys, app.cli.run_names; assert not {'sqlalchemy', 'alembic'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
