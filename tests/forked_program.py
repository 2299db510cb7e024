"""Programs of this checkout, forked from a process that has loaded them: a server costs 3 s of CPU less, a worker 2 s.

What they start as ``python -m`` is forked as well.

For tests that are not about the start of a process.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from pkgutil import resolve_name
from typing import IO

from tests.forking_popen import install_forking_popen

__all__ = ["ForkedProgram", "run_forked"]

_FORK_SERVER = multiprocessing.get_context("forkserver")
# There is one such process, and the first use starts it, so it loads what any test needs; modules of tests need pytest.
_FORK_SERVER.set_forkserver_preload([__name__, "pytest", "tests.preload", "app.worker", "tsr_engine.runs.track_video"])


class ForkedProgram:
    """The part of ``subprocess.Popen`` that tests need.

    Attributes:
        stdout, stderr: its standard output and error, if they are pipes.
    """

    def __init__(
        self,
        program: str,
        arguments: Sequence[str] = (),
        env: Mapping[str, str] | None = None,
        cwd: Path | None = None,
        stdin: int | None = None,
        stdout: int | None = None,
        stderr: int | None = None,
    ) -> None:
        """Start it.

        Args:
            program: ``module:function``; it takes the arguments and returns the exit code.
            arguments: of the command.
            env: its environment; None: this process's.
            cwd: its folder; None: this process's.
            stdin: a file that it reads; None: an empty one.
            stdout: ``subprocess.PIPE``, or None for what the first such process got.
            stderr: ``subprocess.PIPE``, ``subprocess.DEVNULL``, or None for this process's.
        """
        self.stdout: IO[str] | None = None
        self.stderr: IO[str] | None = None
        stdin_fd = os.open(os.devnull, os.O_RDONLY) if stdin in (None, subprocess.DEVNULL) else os.dup(stdin)
        if stderr == subprocess.PIPE:
            end, stderr_fd = os.pipe()
            self.stderr = os.fdopen(end)
        else:
            stderr_fd = os.dup(2) if stderr is None else os.open(os.devnull, os.O_WRONLY)
        # a connection is what multiprocessing hands on to a process that is no child
        streams = {0: Connection(stdin_fd, writable=False), 2: Connection(stderr_fd, readable=False)}
        if stdout == subprocess.PIPE:
            end, stdout_fd = os.pipe()
            self.stdout = os.fdopen(end, encoding="utf-8")
            streams[1] = Connection(stdout_fd, readable=False)
        call = (program, list(arguments), dict(os.environ if env is None else env), cwd or Path.cwd(), streams)
        self._process: BaseProcess = _FORK_SERVER.Process(target=_run, args=call)
        self._process.start()
        for stream in streams.values():
            stream.close()

    @property
    def pid(self) -> int:
        """Its process id."""
        assert self._process.pid is not None
        return self._process.pid

    @property
    def returncode(self) -> int | None:
        """Its exit code; None: it runs."""
        return self._process.exitcode

    def poll(self) -> int | None:
        """Its exit code; None: it runs."""
        return self._process.exitcode

    def send_signal(self, signal_number: signal.Signals) -> None:
        """Send it a signal, if it runs."""
        if self.poll() is None:
            os.kill(self.pid, signal_number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """Kill it."""
        self.send_signal(signal.SIGKILL)

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end; returns the exit code.

        Raises:
            subprocess.TimeoutExpired: it still runs.
        """
        self._process.join(timeout)
        if (code := self.poll()) is None:
            raise subprocess.TimeoutExpired("a forked program", timeout or 0)
        return code


def run_forked(program: str, arguments: Sequence[str], env: Mapping[str, str]) -> tuple[int, str]:
    """Run a program; returns its exit code and what it wrote to standard error."""
    process = ForkedProgram(program, arguments, env, stderr=subprocess.PIPE)
    assert process.stderr is not None
    with process.stderr as stream:
        text = stream.read()
    return process.wait(60), text


def _run(
    program: str, arguments: list[str], environment: Mapping[str, str], folder: Path, streams: Mapping[int, Connection]
) -> None:
    """Run a program in the forked process, with its own streams, environment and folder."""
    gc.freeze()  # loaded modules are never collected, so their pages stay shared; also by processes forked later
    for number, stream in streams.items():
        os.dup2(stream.fileno(), number)
        stream.close()
    sys.stdin = os.fdopen(0, encoding="utf-8", closefd=False)  # multiprocessing has put an empty one in its place
    if 1 in streams:  # what it had may be a file, in which it seeks
        sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    install_forking_popen()
    sys.exit(resolve_name(program)(arguments))
