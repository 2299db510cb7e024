"""The server's side of cages: start one within milliseconds, exchange messages, stop it.

No cage outlives its server.
"""

from __future__ import annotations

import atexit
import os
import pickle
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final

from app.cages.failures import CageError, raised
from app.cages.limits import Limits
from app.cages.talk import Ended, Talk
from tsr_engine.json_shapes import JsonObject

__all__ = ["Cage", "CageError", "Cages", "CagesClosed"]

_LOOK_MS: Final = 50
"""Milliseconds between checks whether the cage is to end."""
_BEGIN: Final = 60.0
"""Seconds that a cage may take to start: the nursery may still be loading, on a busy machine."""


class CagesClosed(CageError):
    """The server ends, or the client has disconnected."""


class Cage:
    """One process. ``talk`` is the connection to it. Any thread may call ``kill`` at any time."""

    def __init__(self, talk: Talk, process: int, limits: Limits) -> None:
        self.talk = talk
        self.limits = limits
        self.process: int | None = process
        self._lock = threading.Lock()

    def kill(self) -> None:
        """End the process at once; a pending ``receive`` raises ``Ended``."""
        with self._lock:
            if self.process is not None:
                with suppress(ProcessLookupError):
                    signal.pidfd_send_signal(self.process, signal.SIGKILL)

    def close(self) -> None:
        """Kill the process and release its resources; closing twice is harmless."""
        self.kill()
        with self._lock:
            if self.process is not None:
                os.close(self.process)
                self.process = None
                self.talk.close()


class _Nursery:
    """The process that cages are forked from, one per server process. It knows no settings."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._orders: socket.socket | None = None

    def start(self) -> None:
        """Start the process unless it runs; it loads its modules in the background."""
        with self._lock:
            self._running()

    def fork(self) -> socket.socket:
        """Fork a cage and return our end of the connection to it.

        Raises:
            CageError: no process could be started.
        """
        ours, theirs = socket.socketpair()
        with theirs, self._lock:
            for _ in range(2):
                try:
                    socket.send_fds(self._running(), [b"."], [theirs.fileno()])
                except OSError:
                    self._stop()  # the nursery was killed: start a new one
                else:
                    return ours
        ours.close()
        raise CageError("no process could be started for it; try again")

    def close(self) -> None:
        """End the nursery and with it all cages."""
        with self._lock:
            self._stop()

    def _running(self) -> socket.socket:
        if self._orders is None:
            ours, theirs = socket.socketpair()
            threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
            environment = {**os.environ, **threads, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
            command = [sys.executable, "-m", "app.cages.nursery"]
            with theirs:
                self._process = subprocess.Popen(command, stdin=theirs.fileno(), env=environment)  # noqa: S603 - our own module
            self._orders = ours
        return self._orders

    def _stop(self) -> None:
        if self._orders is not None and self._process is not None:
            self._orders.close()
            self._process.kill()
            self._process.wait()
            self._orders, self._process = None, None


_NURSERY: Final = _Nursery()
"""Module state because it holds only the process, which ends with this one."""
atexit.register(_NURSERY.close)


class Cages:
    """The cages of one server."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._open: set[Cage] = set()
        self._closed = False

    def warm(self) -> None:
        """Start the nursery, so that later cages start at once."""
        _NURSERY.start()

    def open(self, function: str, *arguments: object, limits: Limits) -> Cage:
        """Start a function in a new cage; it can send messages meanwhile.

        Args:
            function: ``module:name``; called with the cage's end of the connection, then with the arguments.
            arguments: anything that can be pickled.
            limits: limits of the cage.

        Raises:
            CageError: no process could be started.
            CagesClosed: the server ends.
        """
        end = _NURSERY.fork()
        end.settimeout(_BEGIN)
        talk = Talk(end)
        try:
            number = int(talk.receive()[0]["number"])
            cage = Cage(talk, os.pidfd_open(number), limits)
        except (Ended, OSError, KeyError, ValueError):
            end.close()
            raise CageError("no process could be started for it; try again") from None
        end.settimeout(None)
        with self._lock:
            closed = self._closed
            if not closed:
                self._open.add(cage)
        if closed:
            cage.close()
            raise CagesClosed("the server ends")
        try:
            talk.send({"function": function}, pickle.dumps((limits, arguments)))
        except Ended:
            self.end(cage)
            raise CageError("the process that was started for it ended at once; try again") from None
        return cage

    def end(self, cage: Cage) -> None:
        """Close a cage."""
        with self._lock:
            self._open.discard(cage)
        cage.close()

    def run(
        self,
        function: str,
        *arguments: object,
        limits: Limits,
        stop: Callable[[], bool] = lambda: False,
        on_message: Callable[[JsonObject], None] = lambda _: None,
    ) -> Any:  # Any: the values of JSON that the function returns
        """Run a function in a cage and return its result as JSON values.

        Args:
            function: as of ``open``.
            arguments: as of ``open``.
            limits: limits of the cage.
            stop: returns whether to give up; called 20 times a second.
            on_message: called with each message of the function.

        Raises:
            CageError: the function exceeded a limit, or its process died.
            CagesClosed: ``stop`` returned true, or the server ends.
            ApiError, TsrError: the function raised it.
        """
        cage = self.open(function, *arguments, limits=limits)
        began = time.monotonic()
        overdue = threading.Timer(limits.wall or threading.TIMEOUT_MAX, cage.kill)
        overdue.daemon = True
        overdue.start()
        looking = select.poll()
        looking.register(cage.talk, select.POLLIN)
        try:
            while True:
                if stop() or self._closed:
                    raise CagesClosed("the client has disconnected, or the server ends")
                if not looking.poll(_LOOK_MS):
                    continue
                said, _ = cage.talk.receive()
                if "found" in said:
                    return said["found"]
                if "failed" in said:
                    raise raised(said["failed"], limits.memory_mb)
                on_message(said)
        except Ended:
            if self._closed or stop():
                raise CagesClosed("the client has disconnected, or the server ends") from None
            if limits.wall and time.monotonic() - began > limits.wall:
                raise CageError(f"it took more than the {limits.wall:.0f} s that it may take") from None
            if limits.computing and time.monotonic() - began > 0.9 * limits.computing:
                raise CageError(f"it needs more than the {limits.computing} s of computing that it may use") from None
            raise CageError("the process that read it died") from None
        finally:
            overdue.cancel()
            self.end(cage)

    def close(self) -> None:
        """Kill all cages; their callers get :class:`CagesClosed`."""
        with self._lock:
            self._closed = True
            cages = list(self._open)
        for cage in cages:
            cage.kill()
