"""Does a run on a node of a Ray cluster, reports its progress and can stop it."""

from __future__ import annotations

import base64
import json
import pickle
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any, Final

from tsr_engine import errors
from tsr_engine.batch.child_process import child_environment
from tsr_engine.batch.cluster import ClusterUnreachable, connect
from tsr_engine.batch.node_task import NodeTask
from tsr_engine.errors import TsrError, UsageError
from tsr_engine.runs.report import Progress, RunReport

_POLL_INTERVAL_S: Final = 0.25
"""Seconds between two polls of a run."""
_NODE_TIMEOUT_S: Final = 60.0
"""Seconds without an answer after which a node counts as dead."""
NOTE_AFTER_S: Final = 5.0
"""Seconds that a node with free CPUs may take to begin without a note."""
WAITING_FOR_NODE: Final = "waiting for a node of the Ray cluster"
"""What a progress line says meanwhile."""
_STOP_TIMEOUT_S: Final = 4.0
"""Seconds that a stopped run has for its last frame."""


class NodeLost(Exception):
    """Raised if the process of a run ends without a message, or its node is lost.

    Attributes:
        code: exit code of the process, below 0: a signal; None: its node is lost.
    """

    def __init__(self, message: str, code: int | None = None) -> None:
        super().__init__(message)
        self.code = code


class ProcessActor:
    """An actor that runs the process on its node; ``lines`` are the messages since the last poll."""

    def __init__(self) -> None:
        self.lines: deque[str] = deque()
        self._process: subprocess.Popen[bytes] | None = None
        self._reader: threading.Thread | None = None

    def start(self, task: bytes) -> None:
        """Start the process."""
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tsr_engine.batch.node_worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=child_environment(),
        )
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):  # the process has died; its exit code says so
            self._process.stdin.write(task)
            self._process.stdin.close()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process is not None
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.lines.append(line.decode())

    def poll(self) -> tuple[list[str], int | None]:
        """Messages since the last call, and the exit code after the last message."""
        assert self._process is not None
        assert self._reader is not None
        code = self._process.poll()
        if code is not None:
            self._reader.join()
        return [self.lines.popleft() for _ in range(len(self.lines))], code

    def stop(self) -> None:
        """Ask the process to end."""
        if self._process is not None:
            self._process.terminate()


def run_on_node(
    task: NodeTask,
    address: str | None,
    progress: Callable[[Progress], None],
    stop: Callable[[], bool],
    note: Callable[[str], None] = lambda _: None,
) -> RunReport | None:
    """Do a run on as many CPUs of a node as it has cores.

    Args:
        task: the run.
        address: ``HOST:PORT`` of a cluster's client server; None: the cluster of this machine.
        progress: called regularly.
        stop: called regularly; True ends the run, which can be resumed.
        note: called with what the run waits for, or what the node does besides its progress, in a few words; empty:
            nothing to say.

    Returns:
        The report; None: it was stopped.

    Raises:
        ClusterUnreachable: the cluster does not answer, or has no node with CPUs at present.
        UsageError: no node is large enough, or a node has another version.
        TsrError: the run failed; the message is that of the node.
        NodeLost: its process or its node has died.
    """
    ray = connect(address, start_local=False)
    runner = None
    try:
        _require_cpus(ray, task.request.cores)
        with _node_errors(ray):
            runner = ray.remote(ProcessActor).options(num_cpus=task.request.cores).remote()
            started = runner.start.remote(pickle.dumps(task))
            noted, late = False, time.monotonic() + NOTE_AFTER_S
            while not ray.wait([started], timeout=_POLL_INTERVAL_S)[0]:  # no node has a free CPU
                if stop():
                    return None
                if not noted and time.monotonic() > late:
                    noted = True
                    note(WAITING_FOR_NODE)
            ray.get(started)
            note("")
            return _watch(ray, runner, progress, stop, note)
    finally:
        if runner is not None:
            with suppress(Exception):  # the connection may have failed
                ray.kill(runner)
        ray.shutdown()


def _watch(
    ray: ModuleType,
    runner: Any,  # Any: a handle that Ray makes for an actor
    progress: Callable[[Progress], None],
    stop: Callable[[], bool],
    note: Callable[[str], None],
) -> RunReport | None:
    stop_requested_at: float | None = None
    while True:
        lines, code = ray.get(runner.poll.remote(), timeout=_NODE_TIMEOUT_S)
        for line in lines:
            message = json.loads(line)
            if "at" in message:
                progress(Progress(**message["at"]))
            elif "note" in message:
                note(message["note"])
            elif "failed" in message:
                raise getattr(errors, message["kind"], TsrError)(message["failed"])
            else:
                report: RunReport = pickle.loads(base64.b64decode(message["done"]))  # noqa: S301 - Ray does as well
                return report
        if code is not None:
            raise NodeLost(f"The process of the run ended without a word (exit code {code}).", code)
        if stop_requested_at is None and stop():
            stop_requested_at = time.monotonic()
            runner.stop.remote()
        elif stop_requested_at is not None and time.monotonic() - stop_requested_at > _STOP_TIMEOUT_S:
            return None
        time.sleep(_POLL_INTERVAL_S)


@contextmanager
def _node_errors(ray: ModuleType) -> Iterator[None]:
    """Raise the error for a node that Ray has lost."""
    try:
        yield
    except ray.exceptions.RayActorError as error:
        text = str(error)
        if "ModuleNotFoundError" in text:
            raise UsageError(
                "A node of the Ray cluster has no tsr. Install the same version, with 'tsr[cluster]', on every node."
            ) from None
        raise NodeLost((text.splitlines() or ["The node of the run has died"])[0]) from None
    except (ray.exceptions.GetTimeoutError, ConnectionError) as error:
        raise NodeLost(f"The node of the run does not answer ({type(error).__name__}).") from None


def _require_cpus(ray: ModuleType, cores: int) -> None:
    max_cpus = max((int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"]), default=0)
    if max_cpus == 0:
        raise ClusterUnreachable("The Ray cluster has no node with a CPU at present.")
    if max_cpus < cores:
        raise UsageError(
            f"A run takes {cores} CPUs of a node, and the largest of the Ray cluster has {max_cpus}. Lower TSR_CORES."
        )
