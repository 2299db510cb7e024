"""Runs the tasks of a batch on this machine or on a Ray cluster. Both executors yield outcomes as they finish."""

from __future__ import annotations

import queue
import subprocess
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from typing import Any, Final

from tsr_engine.batch.cluster import connect
from tsr_engine.batch.process import MAX_ATTEMPTS, run_task
from tsr_engine.batch.task import DriveTask, Outcome
from tsr_engine.json_shapes import JsonObject

_NOTE_WAIT_S: Final = 5.0
"""Seconds to wait for the notes."""
TaskProgress = Callable[[int, int, int | None], None]
"""Called with the index of a task, the frames done and the total."""
Outcomes = Iterator[tuple[int, Outcome]]


def run_locally(
    tasks: Sequence[DriveTask],
    jobs: int,
    progress: TaskProgress,
    stop: Callable[[], bool],
    note: Callable[[str], None] = lambda _: None,
) -> Outcomes:
    """Run tasks, ``jobs`` at a time.

    Args:
        tasks: run in this order.
        jobs: processes at a time, >= 1.
        progress: called in several threads.
        stop: called between tasks and while waiting; True kills the running processes. The next call resumes drives.
        note: called in several threads with what a process does before it tracks.
    """
    pool = _LocalPool(tasks, progress, note)
    threads = [threading.Thread(target=pool.work, name="tsr-batch", daemon=True) for _ in range(min(jobs, len(tasks)))]
    for thread in threads:
        thread.start()
    remaining = len(tasks)
    try:
        while remaining and not stop():
            with suppress(queue.Empty):
                ended = pool.ended.get(timeout=0.2)
                if isinstance(ended, BaseException):
                    raise ended
                remaining -= 1
                yield ended
    finally:
        pool.stop()
        for thread in threads:
            thread.join()


def _run_with_retries(run: Callable[[], Outcome], is_stopped: Callable[[], bool] = lambda: False) -> Outcome:
    """Run a task, and repeat it if its process dies: at most ``MAX_ATTEMPTS`` times, and not after a stop."""
    outcome = run()
    for _ in range(MAX_ATTEMPTS - 1):
        if not outcome.died or is_stopped():
            break
        outcome = run()
    return outcome


class _LocalPool:
    """State shared by the threads that run tasks on this machine."""

    def __init__(self, tasks: Sequence[DriveTask], progress: TaskProgress, note: Callable[[str], None]) -> None:
        self._waiting = deque(enumerate(tasks))
        self._progress = progress
        self._note = note
        self._running: set[subprocess.Popen[str]] = set()
        self._stopped = threading.Event()
        self.ended: queue.SimpleQueue[tuple[int, Outcome] | BaseException] = queue.SimpleQueue()

    def work(self) -> None:
        """Run tasks until none are left."""
        try:
            while self._waiting and not self._stopped.is_set():
                try:
                    index, task = self._waiting.popleft()
                except IndexError:  # another thread took the last task
                    return
                run = partial(run_task, task, partial(self._progress, index), self._on_start, self._note)
                outcome = _run_with_retries(run, self._stopped.is_set)
                if not self._stopped.is_set():
                    self.ended.put((index, outcome))
        except BaseException as error:  # noqa: BLE001 - raised again in the consumer's thread
            self.ended.put(error)

    def stop(self) -> None:
        """Kill the running processes, and start no more."""
        self._stopped.set()
        for process in list(self._running):
            process.kill()

    def _on_start(self, process: subprocess.Popen[str]) -> None:
        self._running.add(process)
        if self._stopped.is_set():
            process.kill()


class _Notes:
    """An actor that collects the notes of a batch."""

    def __init__(self) -> None:
        self._notes: list[str] = []

    def put(self, note: str) -> None:
        """Add a note."""
        self._notes.append(note)

    def take(self) -> list[str]:
        """Notes since the last call."""
        taken, self._notes = self._notes, []
        return taken


def run_on_ray(
    tasks: Sequence[DriveTask],
    address: str | None,
    progress: TaskProgress,
    stop: Callable[[], bool],
    note: Callable[[str], None] = lambda _: None,
) -> Outcomes:
    """Run tasks on a Ray cluster, each on as many CPUs as it has cores.

    Videos, models and the folder of results must be on a file system that all nodes see under the same names. If a
    node dies, its drives are tried again from their last stored frames.

    Args:
        tasks: one per drive.
        address: ``HOST:PORT`` of a cluster's client server; None: the cluster of this machine, or one started on this
            machine alone.
        progress: called when a drive ends.
        stop: as for :func:`run_locally`.
        note: called with what a process on a node does before it tracks.

    Raises:
        UsageError: Ray is not installed, or the cluster cannot be reached.
    """
    ray = connect(address, start_local=True)

    @ray.remote(max_retries=MAX_ATTEMPTS - 1)  # type: ignore[untyped-decorator]
    def run_remotely(content: JsonObject, notes: Any) -> JsonObject:  # Any: a handle that Ray makes for an actor
        outcome = _run_with_retries(lambda: run_task(DriveTask(**content), note=notes.put.remote))
        return {"result": outcome.result, "error": outcome.error, "died": outcome.died}

    notes = ray.remote(num_cpus=0)(_Notes).remote()
    running = {run_remotely.options(num_cpus=task.cores).remote(asdict(task), notes): k for k, task in enumerate(tasks)}
    try:
        while running and not stop():
            done, _ = ray.wait(list(running), num_returns=1, timeout=0.5)
            with suppress(ray.exceptions.RayError):  # the node with the notes has died
                for text in ray.get(notes.take.remote(), timeout=_NOTE_WAIT_S):
                    note(text)
            for reference in done:
                index = running.pop(reference)
                try:
                    outcome = Outcome(**ray.get(reference))
                except ray.exceptions.RayError as error:
                    first = (str(error).splitlines() or [type(error).__name__])[0]
                    outcome = Outcome(None, f"Ray gave the drive up after {MAX_ATTEMPTS} tries: {first}", died=True)
                if outcome.result is not None:
                    progress(index, outcome.result["frames"], outcome.result["frames"])
                yield index, outcome
    finally:
        for reference in running:
            ray.cancel(reference, force=True)
        ray.shutdown()
