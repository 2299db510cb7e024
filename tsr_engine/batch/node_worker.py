"""Does one run in a process of a node: ``python -m tsr_engine.batch.node_worker``.

The pickled task comes on stdin; progress and outcome go to stdout, one line of JSON each. SIGTERM ends the run after
the current frame. Stored frames are kept, and the next process resumes after them.
"""

from __future__ import annotations

import base64
import os
import pickle
import signal
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Final

from tsr_engine.batch.child_process import exit_with_parent, limit_memory, require_models, send_message, send_note
from tsr_engine.batch.node_task import NodeTask
from tsr_engine.compilation import report_compilation
from tsr_engine.errors import EvidenceError, ModelError, TsrError, UsageError
from tsr_engine.evidence.schema import LOCK_FILE
from tsr_engine.io.locks import is_locked
from tsr_engine.runs.report import Progress, RunReport
from tsr_engine.version import __version__

_LOCK_TIMEOUT_S: Final = 60.0
"""Seconds to wait for another process that writes the same evidence, because its machine may just have been lost."""
PROGRESS_INTERVAL_S: Final = 0.3
"""Seconds between two messages about the progress."""


def main() -> None:
    """Read a task, run it, and report the outcome."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    stop_signals: list[int] = []
    signal.signal(signal.SIGTERM, lambda sign, _: stop_signals.append(sign))
    exit_with_parent(os.getppid())
    os.nice(10)
    try:
        task: NodeTask = pickle.load(sys.stdin.buffer)  # noqa: S301 - from the parent process
        send_message({"done": base64.b64encode(pickle.dumps(run_task(task, stop_signals))).decode()})
    except TsrError as error:
        send_message({"failed": str(error), "kind": type(error).__name__})
    except MemoryError:
        send_message({"failed": f"The file needs more than {task.memory_mb} MiB of memory.", "kind": "InputError"})


def run_task(task: NodeTask, stop_signals: list[int]) -> RunReport:
    """Do a task and report its progress.

    Args:
        task: the run.
        stop_signals: signals that have asked this process to end; the run ends when there is one.

    Raises:
        UsageError: the task comes from another version.
        TsrError: the run failed.
    """
    from tsr_engine.pipeline import load_components
    from tsr_engine.runs.track_video import track_video

    if task.version != __version__:
        raise UsageError(
            f"{os.uname().nodename} has tsr {__version__}, and the server has {task.version}. Install the same "
            "version on every node."
        )
    limit_memory(task.memory_mb)
    try:
        components = load_components(task.request.params, task.models)
    except ModelError as error:
        raise ModelError(f"{os.uname().nodename}: {error}") from None
    require_models(task.digests, components.models)
    if task.request.evidence is not None:
        _wait_for_lock(task.request.evidence)
    last_report = 0.0

    def show(progress: Progress) -> None:
        nonlocal last_report
        if time.monotonic() - last_report >= PROGRESS_INTERVAL_S:
            last_report = time.monotonic()
            send_message({"at": asdict(progress)})

    with report_compilation(send_note, PROGRESS_INTERVAL_S):
        return track_video(task.request, components, progress=show, stop=lambda: bool(stop_signals))


def _wait_for_lock(folder: Path) -> None:
    deadline = time.monotonic() + _LOCK_TIMEOUT_S
    while is_locked(folder / LOCK_FILE):
        if time.monotonic() > deadline:
            raise EvidenceError(f"Another process still writes {folder}. Start the run again when it has ended.")
        time.sleep(0.2)


if __name__ == "__main__":
    main()
