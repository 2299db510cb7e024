"""A live server whose processes are forked from one with all modules loaded, which saves seconds of CPU each."""

from __future__ import annotations

import os
import socket
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from app.cli.main import run
from tests.e2e.live_server import LiveServer
from tests.forked_program import ForkedProgram

__all__ = ["ForkedServer"]

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

    def _begin(self, command: Sequence[str], log: IO[bytes]) -> ForkedProgram:
        return ForkedProgram(f"{__name__}:serve", [log.name, *command])


def _free(port: int) -> bool:
    """Whether a server can have the port."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def serve(arguments: list[str]) -> int:
    """Behave like ``tsr`` with the arguments after the first, which names the file that takes the output."""
    log, *command = arguments
    with Path(log).open("ab", buffering=0) as out:
        for stream in (1, 2):
            os.dup2(out.fileno(), stream)
    return run(command)


def run_to_file(arguments: list[str]) -> int:
    """Behave like ``tsr`` with the arguments after the first, which names a new file for the standard output."""
    output_path, *command = arguments
    with Path(output_path).open("wb") as out:
        os.dup2(out.fileno(), 1)
    return run(command)
