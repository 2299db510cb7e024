"""A worker for ``tests/attack``: its jobs wait for a file, or end their process."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from app.jobs.context import Stopped, TaskContext
from app.jobs.kinds import JobKinds
from app.jobs.tasks import TaskKind
from app.jobs.worker import main


def wait(task: TaskContext) -> None:
    """Wait until the file exists."""
    while not Path(task.job.payload["until"]).exists():
        if task.should_stop():
            raise Stopped
        time.sleep(0.02)


def die(task: TaskContext) -> None:
    """Send this process the signal in the payload."""
    with task.write() as session:
        task.record_progress(session, task.job.payload["at"])
    os.kill(os.getpid(), getattr(signal, task.job.payload["signal"]))
    time.sleep(60)


def leave(task: TaskContext) -> None:
    """End this process with the exit code in the payload."""
    os._exit(task.job.payload["code"])


KINDS = JobKinds(
    (
        TaskKind(name="wait", lane="short", load=lambda: wait, on_failed=lambda *_: None, by_frame=True),
        TaskKind(name="die", lane="short", load=lambda: die, on_failed=lambda *_: None, by_frame=True),
        TaskKind(name="leave", lane="long", load=lambda: leave, on_failed=lambda *_: None, by_frame=True),
    ),
    worker="tests.attack.dying_worker",
)


def do_jobs(arguments: list[str]) -> int:
    """Behave like ``app.worker`` with these kinds, below the process that this one is forked from."""
    return main(KINDS, [str(os.getppid()), *arguments])
