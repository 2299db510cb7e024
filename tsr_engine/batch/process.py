"""Runs one task in a process and waits for it, so that a crash affects no other drive."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict
from typing import Final

from tsr_engine.batch.child_process import child_environment
from tsr_engine.batch.task import DriveTask, Outcome

MAX_ATTEMPTS: Final = 3
"""Number of tries for a drive whose process dies without a message."""
FrameProgress = Callable[[int, int | None], None]


def run_task(
    task: DriveTask,
    progress: FrameProgress = lambda done, total: None,
    on_start: Callable[[subprocess.Popen[str]], None] = lambda _: None,
    note: Callable[[str], None] = lambda _: None,
) -> Outcome:
    """Run a task in a separate process.

    Args:
        task: the task.
        progress: called with frames done, and the total if known.
        on_start: called with the process, which the caller may kill.
        note: called with what the process does before it tracks; empty: that is over.
    """
    process = subprocess.Popen(
        [sys.executable, "-m", "tsr_engine.batch.worker"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8", env=child_environment(),
    )  # fmt: skip
    with process:
        on_start(process)
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            json.dump(asdict(task), process.stdin)
            process.stdin.close()
        except BrokenPipeError:
            pass  # the process has died; its exit code says so below
        outcome = None
        for line in process.stdout:
            message = json.loads(line)
            if "at" in message:
                progress(message["at"], message["of"])
            elif "note" in message:
                note(message["note"])
            else:
                outcome = Outcome(message.get("done"), message.get("failed", ""))
    return outcome or Outcome(None, _exit_reason(process.returncode), died=True)


def _exit_reason(code: int) -> str:
    if code == -signal.SIGKILL:
        return "Its process was killed, perhaps because the machine ran out of memory."
    if code < 0:
        return f"Its process was ended by {signal.Signals(-code).name}."
    return f"Its process ended without a message (exit code {code})."
