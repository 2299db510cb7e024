"""A live server whose processes are forked from one with all modules loaded, which saves seconds of CPU each."""

from __future__ import annotations

import multiprocessing
import os
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

from app.cli.main import run
from tests.e2e.forked_processes import fork_processes
from tests.e2e.live_server import LiveServer

__all__ = ["ForkedServer"]

_FORKS = multiprocessing.get_context("forkserver")
_FORKS.set_forkserver_preload([__name__, "tests.e2e.loaded"])


_ports: list[int] = []
"""The port of the first server."""


class ForkedServer(LiveServer):
    """A :class:`LiveServer` of this checkout.

    One has the port of the other before it, if that is free, so that browsers keep the files of the page.
    """

    def start(self, port: int = 0) -> None:
        super().start(port or next(filter(_free, _ports), 0))
        if not _ports:
            _ports.append(int(self.base.rpartition(":")[2]))

    def _begin(self, command: Sequence[str], log: IO[bytes]) -> _Forked:
        return _Forked(command, Path(log.name))


class _Forked:
    """The part of ``subprocess.Popen`` that a server needs."""

    def __init__(self, command: Sequence[str], log: Path) -> None:
        self._process = _FORKS.Process(target=_serve, args=(list(command), log, dict(os.environ), Path.cwd()))
        self._process.start()

    @property
    def pid(self) -> int:
        assert self._process.pid is not None
        return self._process.pid

    def poll(self) -> int | None:
        return self._process.exitcode

    def terminate(self) -> None:
        self._process.terminate()

    def kill(self) -> None:
        self._process.kill()

    def wait(self, timeout: float | None = None) -> int:
        self._process.join(timeout)
        if (code := self.poll()) is None:
            raise subprocess.TimeoutExpired("tsr review", timeout or 0)
        return code


def _free(port: int) -> bool:
    """Whether a server can have the port."""
    with socket.socket() as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def _serve(command: list[str], log: Path, environment: Mapping[str, str], folder: Path) -> None:
    """Behave like a separate process with this command, output, environment and folder."""
    with log.open("ab", buffering=0) as out:
        for stream in (1, 2):
            os.dup2(out.fileno(), stream)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    fork_processes()
    sys.exit(run(command))
