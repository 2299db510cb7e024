"""A process that detects frames for its parent.

The process is forked. So it starts within milliseconds with everything loaded and compiled, takes any detector, and
works where other programs must not start. Because its parent has threads, it does nothing but detect: it closes the
parent's files, collects no garbage, and exits without clean-up. OpenCV's threads end before the fork, since a child
would wait for them forever.

Pictures go through shared memory, detections through a pipe. The process ends with its parent, because the pipe then
closes.
"""

from __future__ import annotations

import gc
import mmap
import os
import signal
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, Pipe
from typing import Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from tsr_engine.pipeline.threads import one_opencv_thread
from tsr_engine.records import Detections, Picture

MAX_QUEUED_FRAMES: Final = 3
"""Largest number of frames of a process: it detects one, and the others are ready while its parent is busy."""

Detect = Callable[[int, Picture], Detections]
"""Computes the detections of a frame from its ordinal and picture."""
Detected = tuple[Detections, float]
"""Detections of a frame, and the seconds that detection took."""


class DetectionProcess:
    """One process that detects.

    Args:
        detect: computes detections.
        shape: shape of all pictures.

    Attributes:
        connection: pipe; readable when the next frame is done or the process has ended.
    """

    def __init__(self, detect: Detect, shape: tuple[int, ...]) -> None:
        memory = mmap.mmap(-1, MAX_QUEUED_FRAMES * int(np.prod(shape)))
        self._pictures = np.frombuffer(memory, np.uint8).reshape(MAX_QUEUED_FRAMES, *shape)
        self._sent = 0
        self.connection, child_connection = Pipe()
        with _safe_to_fork():
            self._process = os.fork()
            if self._process == 0:
                _serve(child_connection, detect, self._pictures)
        child_connection.close()

    def send(self, ordinal: int, picture: Picture) -> None:
        """Send a frame to detect; at most ``MAX_QUEUED_FRAMES`` at a time.

        Raises:
            OSError: the process has ended.
        """
        slot = self._sent % MAX_QUEUED_FRAMES
        self._pictures[slot] = picture
        self.connection.send((slot, ordinal))
        self._sent += 1

    def receive(self) -> Detected | None:
        """The detections of the oldest frame in work; None: detection failed.

        Raises:
            EOFError, OSError: the process has ended.
        """
        detected: Detected | None = self.connection.recv()
        return detected

    def close(self) -> None:
        """End the process at once."""
        self.connection.close()
        with suppress(ProcessLookupError):
            os.kill(self._process, signal.SIGKILL)
        with suppress(ChildProcessError):
            os.waitpid(self._process, 0)


@contextmanager
def _safe_to_fork() -> Iterator[None]:
    """A block in which a fork is safe: without threads of OpenCV, and without signals for this thread."""
    with one_opencv_thread():
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        try:
            with warnings.catch_warnings():
                # Python 3.12 warns about every fork of a process with threads.
                warnings.simplefilter("ignore", DeprecationWarning)
                yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def _serve(connection: Connection, detect: Detect, pictures: NDArray[np.uint8]) -> NoReturn:
    """Detect until the parent closes the pipe or ends."""
    try:
        gc.disable()
        gc.freeze()  # no finalisers here: objects such as decoders belong to the parent
        signal.set_wakeup_fd(-1)
        for number in signal.valid_signals():
            if callable(signal.getsignal(number)):
                signal.signal(number, signal.SIG_DFL)
        for number in (signal.SIGINT, signal.SIGTERM):  # both reach the whole process group; the parent handles them
            signal.signal(number, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        _close_all_but(connection.fileno())
        while True:
            slot, ordinal = connection.recv()
            started = time.perf_counter()
            try:
                detected = detect(ordinal, pictures[slot]), time.perf_counter() - started
            except Exception:  # noqa: BLE001 - the parent detects the frame itself, and meets the same
                connection.send(None)
            else:
                connection.send(detected)
    except BaseException:  # noqa: BLE001 - nothing may run that belongs to the parent
        os._exit(0)


def _close_all_but(kept_fd: int) -> None:
    """Close the parent's files except ``kept_fd`` and stderr, so that they really close when the parent closes them."""
    null_fd = os.open(os.devnull, os.O_RDWR)
    for standard_fd in (0, 1):
        os.dup2(null_fd, standard_fd)
    os.closerange(3, kept_fd)
    os.closerange(kept_fd + 1, os.sysconf("SC_OPEN_MAX"))
