"""Does one run in a process of a node: ``python -m tsr_engine.batch.node_worker``.

The pickled order comes on stdin; progress and outcome go to stdout, one line of JSON each. SIGTERM ends the run after
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

__all__ = ["PROGRESS_INTERVAL_S", "main", "run_task"]

_LOCK_TIMEOUT_S: Final = 60.0
"""Seconds to wait for another process that writes the same evidence, because its machine may just have been lost."""
PROGRESS_INTERVAL_S: Final = 0.3
"""Seconds between two messages about the progress."""


def main() -> None:
    """Read an order, run it, and report the outcome."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    asked: list[int] = []
    signal.signal(signal.SIGTERM, lambda sign, _: asked.append(sign))
    exit_with_parent(os.getppid())
    os.nice(10)
    try:
        order: NodeTask = pickle.load(sys.stdin.buffer)  # noqa: S301 - from the parent process
        send_message({"done": base64.b64encode(pickle.dumps(run_task(order, asked))).decode()})
    except TsrError as error:
        send_message({"failed": str(error), "kind": type(error).__name__})
    except MemoryError:
        send_message({"failed": f"The file needs more than {order.memory_mb} MiB of memory.", "kind": "InputError"})


def run_task(order: NodeTask, asked: list[int]) -> RunReport:
    """Do an order and report its progress.

    Args:
        order: the run.
        asked: signals that have asked this process to end; the run ends when there is one.

    Raises:
        UsageError: the order comes from another version.
        TsrError: the run failed.
    """
    from tsr_engine.pipeline import load_components
    from tsr_engine.runs.track_video import track_video

    if order.version != __version__:
        raise UsageError(
            f"{os.uname().nodename} has tsr {__version__}, and the server has {order.version}. Install the same "
            "version on every node."
        )
    limit_memory(order.memory_mb)
    try:
        components = load_components(order.request.params, order.models)
    except ModelError as error:
        raise ModelError(f"{os.uname().nodename}: {error}") from None
    require_models(order.digests, components.models)
    if order.request.evidence is not None:
        _wait_for_lock(order.request.evidence)
    reported = 0.0

    def show(progress: Progress) -> None:
        nonlocal reported
        if time.monotonic() - reported >= PROGRESS_INTERVAL_S:
            reported = time.monotonic()
            send_message({"at": asdict(progress)})

    with report_compilation(send_note, PROGRESS_INTERVAL_S):
        return track_video(order.request, components, progress=show, stop=lambda: bool(asked))


def _wait_for_lock(folder: Path) -> None:
    until = time.monotonic() + _LOCK_TIMEOUT_S
    while is_locked(folder / LOCK_FILE):
        if time.monotonic() > until:
            raise EvidenceError(f"Another process still writes {folder}. Start the run again when it has ended.")
        time.sleep(0.2)


if __name__ == "__main__":
    main()
