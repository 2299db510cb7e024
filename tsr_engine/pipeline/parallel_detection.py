"""Detection on several cores: processes detect frames in parallel, and the frames come out in order.

Detection has no state, so a run stores the same bytes on any number of cores. Tracking needs the frames in order and
stays in this process, which also detects if the next frame is not ready. No core waits while there is a frame to
detect. With ``d`` seconds of detection and ``t`` of other work, ``n`` cores take ``max((d + t) / n, t)`` seconds per
frame.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from typing import Generic, Protocol, TypeVar

from tsr_engine.pipeline.detection_process import MAX_QUEUED_FRAMES, Detect, Detected, DetectionProcess
from tsr_engine.records import Picture


class _HasPicture(Protocol):
    @property
    def ordinal(self) -> int: ...
    @property
    def picture(self) -> Picture: ...


F = TypeVar("F", bound=_HasPicture)


@dataclass(slots=True)
class _QueuedFrame(Generic[F]):
    """A frame in the queue.

    Attributes:
        state: ``pending``: waits for any process; ``local``: waits for this process; ``sent``: another process works on
            it; ``done``: has detections or a failure, or is not wanted.
    """

    frame: F
    number: float
    state: str
    detected: Detected | None = None
    failure: Exception | None = None


@dataclass(slots=True)
class _BusyProcess(Generic[F]):
    """A process and its frames, in order."""

    process: DetectionProcess
    queue: deque[_QueuedFrame[F]] = field(default_factory=deque)


class _DetectionQueue(Generic[F]):
    """The frames between decoding and tracking."""

    def __init__(self, detect: Detect, cores: int) -> None:
        self._detect = detect
        self._startable = cores - 1
        self._is_warm = False
        self._processes: list[_BusyProcess[F]] = []
        self.waiting: deque[_QueuedFrame[F]] = deque()

    @property
    def is_full(self) -> bool:
        """Whether enough frames wait to keep all cores busy."""
        processes = len(self._processes) + (self._is_warm and self._startable > 0)
        return len(self.waiting) > (MAX_QUEUED_FRAMES + 1) * processes

    def take_first(self) -> _QueuedFrame[F]:
        """The first frame, once it is done; until then, this process detects others."""
        first = self.waiting[0]
        while first.state != "done":
            self._collect(0.0)
            self._dispatch()
            if first.state == "done":
                break
            local = next((queued for queued in self.waiting if queued.state in {"pending", "local"}), None)
            if local is None:
                self._collect(None)
            else:
                self._detect_locally(local)
        return self.waiting.popleft()

    def _detect_locally(self, queued: _QueuedFrame[F]) -> None:
        started = time.perf_counter()
        try:
            queued.detected = self._detect(queued.frame.ordinal, queued.frame.picture), time.perf_counter() - started
        except Exception as error:  # noqa: BLE001 - raised when it is the frame's turn
            queued.failure = error
        queued.state = "done"
        self._is_warm = True

    def _dispatch(self) -> None:
        """Send pending frames to processes that have room for them."""
        for queued in [waiting for waiting in self.waiting if waiting.state == "pending"]:
            busy = self._process_with_room(queued.frame.picture.shape)
            if busy is None:
                return
            try:
                busy.process.send(queued.frame.ordinal, queued.frame.picture)
            except OSError:
                self._drop_process(busy)
                continue
            queued.state = "sent"
            busy.queue.append(queued)

    def _process_with_room(self, shape: tuple[int, ...]) -> _BusyProcess[F] | None:
        """The process with the fewest frames, or a new one if all have work; None if all are full.

        Processes start after the first frame, so that they share what it loaded and compiled.
        """
        idlest = min(self._processes, key=lambda working: len(working.queue), default=None)
        if (idlest is None or idlest.queue) and self._is_warm and self._startable:
            self._startable -= 1
            idlest = _BusyProcess(DetectionProcess(self._detect, shape))
            self._processes.append(idlest)
        return None if idlest is None or len(idlest.queue) == MAX_QUEUED_FRAMES else idlest

    def _collect(self, seconds: float | None) -> None:
        """Take the results of processes; wait at most ``seconds`` for the first, None: without limit."""
        if not self._processes:
            return
        ready = wait([busy.process.connection for busy in self._processes], seconds)
        for busy in [process for process in self._processes if process.process.connection in ready]:
            try:
                detected = busy.process.receive()
            except (EOFError, OSError):
                self._drop_process(busy)
                continue
            queued = busy.queue.popleft()
            queued.detected, queued.state = detected, "local" if detected is None else "done"

    def _drop_process(self, busy: _BusyProcess[F]) -> None:
        """Continue without a process that has ended, for example because memory ran out."""
        for queued in busy.queue:
            queued.state = "pending"
        self._processes.remove(busy)
        busy.process.close()

    def close(self) -> None:
        """End all processes."""
        for busy in self._processes:
            busy.process.close()
        self._processes.clear()


def detect_in_parallel(
    frames: Iterator[tuple[F, float]], detect: Detect, cores: int, is_wanted: Callable[[F], bool] = lambda _: True
) -> Iterator[tuple[F, float, Detected | None]]:
    """Yield frames with their detections, in order.

    Args:
        frames: frames whose pictures have one shape, each with a number that is passed on.
        detect: computes the detections of a frame from its ordinal and picture, in this process or another.
        cores: number of processes that detect, >= 1, this one included. At most four frames per core are in memory.
        is_wanted: whether to detect a frame; the others come with None.

    Yields:
        Frame, its number, and its detections with their seconds.

    Raises:
        ValueError: ``cores`` is below 1.
        Exception: any error of ``frames`` or ``detect``, after the frames before it.
    """
    if cores < 1:
        raise ValueError(f"cores must be at least 1. Got {cores}.")
    queue: _DetectionQueue[F] = _DetectionQueue(detect, cores)
    failure: Exception | None = None
    has_more = True
    try:
        while True:
            while has_more and not queue.is_full:
                try:
                    item = next(frames, None)
                except Exception as error:  # noqa: BLE001 - raised after the frames before
                    failure, item = error, None
                if item is None:
                    has_more = False
                else:
                    queue.waiting.append(_QueuedFrame(*item, state="pending" if is_wanted(item[0]) else "done"))
            if not queue.waiting:
                break
            first = queue.take_first()
            if first.failure is not None:
                raise first.failure
            yield first.frame, first.number, first.detected
    finally:
        queue.close()
    if failure is not None:
        raise failure
