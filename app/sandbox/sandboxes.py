"""The server's side of sandboxes: start one within milliseconds, exchange messages, stop it.

No sandbox outlives its server.
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

from app.sandbox.channel import Channel, ChannelClosed
from app.sandbox.failures import SandboxError, decode_failure
from app.sandbox.limits import Limits
from tsr_engine.json_shapes import JsonObject

__all__ = ["Sandbox", "SandboxError", "Sandboxes", "SandboxesClosed"]

_POLL_MS: Final = 50
"""Milliseconds between checks whether the sandbox is to end."""
_START_TIMEOUT_S: Final = 60.0
"""Seconds that a sandbox may take to start: the fork server may still be loading, on a busy machine."""


class SandboxesClosed(SandboxError):
    """The server ends, or the client has disconnected."""


class Sandbox:
    """One process. ``channel`` is the connection to it. Any thread may call ``kill`` at any time."""

    def __init__(self, channel: Channel, process: int, limits: Limits) -> None:
        self.channel = channel
        self.limits = limits
        self.process: int | None = process
        self._lock = threading.Lock()

    def kill(self) -> None:
        """End the process at once; a pending ``receive`` raises ``ChannelClosed``."""
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
                self.channel.close()


class _ForkServer:
    """The process that sandboxes are forked from, one per server process. It knows no settings."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None

    def start(self) -> None:
        """Start the process unless it runs; it loads its modules in the background."""
        with self._lock:
            self._ensure_started()

    def fork(self) -> socket.socket:
        """Fork a sandbox and return the server's end of the connection to it.

        Raises:
            SandboxError: no process could be started.
        """
        server_end, child_end = socket.socketpair()
        with child_end, self._lock:
            for _ in range(2):
                try:
                    socket.send_fds(self._ensure_started(), [b"."], [child_end.fileno()])
                except OSError:
                    self._stop()  # the fork server was killed: start a new one
                else:
                    return server_end
        server_end.close()
        raise SandboxError("no process could be started for it; try again")

    def close(self) -> None:
        """End the fork server and with it all sandboxes."""
        with self._lock:
            self._stop()

    def _ensure_started(self) -> socket.socket:
        if self._control is None:
            server_end, child_end = socket.socketpair()
            threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
            environment = {**os.environ, **threads, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
            command = [sys.executable, "-m", "app.sandbox.fork_server"]
            with child_end:
                self._process = subprocess.Popen(command, stdin=child_end.fileno(), env=environment)  # noqa: S603 - our own module
            self._control = server_end
        return self._control

    def _stop(self) -> None:
        if self._control is not None and self._process is not None:
            self._control.close()
            self._process.kill()
            self._process.wait()
            self._control, self._process = None, None


_FORK_SERVER: Final = _ForkServer()
"""Module state because it holds only the process, which ends with this one."""
atexit.register(_FORK_SERVER.close)


class Sandboxes:
    """The sandboxes of one server."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._open: set[Sandbox] = set()
        self._closed = False

    def warm(self) -> None:
        """Start the fork server, so that later sandboxes start at once."""
        _FORK_SERVER.start()

    def open(self, function: str, *arguments: object, limits: Limits) -> Sandbox:
        """Start a function in a new sandbox; it can send messages meanwhile.

        Args:
            function: ``module:name``; called with the sandbox's end of the connection, then with the arguments.
            arguments: anything that can be pickled.
            limits: limits of the sandbox.

        Raises:
            SandboxError: no process could be started.
            SandboxesClosed: the server ends.
        """
        connection = _FORK_SERVER.fork()
        connection.settimeout(_START_TIMEOUT_S)
        channel = Channel(connection)
        try:
            pid = int(channel.receive()[0]["pid"])
            sandbox = Sandbox(channel, os.pidfd_open(pid), limits)
        except (ChannelClosed, OSError, KeyError, ValueError):
            connection.close()
            raise SandboxError("no process could be started for it; try again") from None
        connection.settimeout(None)
        with self._lock:
            closed = self._closed
            if not closed:
                self._open.add(sandbox)
        if closed:
            sandbox.close()
            raise SandboxesClosed("the server ends")
        try:
            channel.send({"function": function}, pickle.dumps((limits, arguments)))
        except ChannelClosed:
            self.end(sandbox)
            raise SandboxError("the process that was started for it ended at once; try again") from None
        return sandbox

    def end(self, sandbox: Sandbox) -> None:
        """Close a sandbox."""
        with self._lock:
            self._open.discard(sandbox)
        sandbox.close()

    def run(
        self,
        function: str,
        *arguments: object,
        limits: Limits,
        stop: Callable[[], bool] = lambda: False,
        on_message: Callable[[JsonObject], None] = lambda _: None,
    ) -> Any:  # Any: the values of JSON that the function returns
        """Run a function in a sandbox and return its result as JSON values.

        Args:
            function: as of ``open``.
            arguments: as of ``open``.
            limits: limits of the sandbox.
            stop: returns whether to give up; called 20 times a second.
            on_message: called with each message of the function.

        Raises:
            SandboxError: the function exceeded a limit, or its process died.
            SandboxesClosed: ``stop`` returned true, or the server ends.
            ApiError, TsrError: the function raised it.
        """
        sandbox = self.open(function, *arguments, limits=limits)
        began = time.monotonic()
        timeout = threading.Timer(limits.wall or threading.TIMEOUT_MAX, sandbox.kill)
        timeout.daemon = True
        timeout.start()
        poll = select.poll()
        poll.register(sandbox.channel, select.POLLIN)
        try:
            while True:
                if stop() or self._closed:
                    raise SandboxesClosed("the client has disconnected, or the server ends")
                if not poll.poll(_POLL_MS):
                    continue
                message, _ = sandbox.channel.receive()
                if "result" in message:
                    return message["result"]
                if "failed" in message:
                    raise decode_failure(message["failed"], limits.memory_mb)
                on_message(message)
        except ChannelClosed:
            if self._closed or stop():
                raise SandboxesClosed("the client has disconnected, or the server ends") from None
            if limits.wall and time.monotonic() - began > limits.wall:
                raise SandboxError(f"it took more than the {limits.wall:.0f} s that it may take") from None
            if limits.computing and time.monotonic() - began > 0.9 * limits.computing:
                raise SandboxError(
                    f"it needs more than the {limits.computing} s of computing that it may use"
                ) from None
            raise SandboxError("the process that read it died") from None
        finally:
            timeout.cancel()
            self.end(sandbox)

    def close(self) -> None:
        """Kill all sandboxes; their callers get :class:`SandboxesClosed`."""
        with self._lock:
            self._closed = True
            sandboxes = list(self._open)
        for sandbox in sandboxes:
            sandbox.kill()
