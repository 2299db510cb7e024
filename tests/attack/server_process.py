"""A server in a separate process, used over HTTP and watched from outside."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.client import HTTPConnection, HTTPMessage
from pathlib import Path
from typing import Any

from tests.forked_program import ForkedProgram
from tests.waiting import time_limit, wait_until

__all__ = ["TOKEN", "PersistentConnection", "ServerProcess", "command_line", "start_server"]

TOKEN = "t" * 24
ROOT = Path(__file__).parents[2]
TREE = Path(os.environ.get("TSR_TREE", ROOT)).resolve()
"""The version that runs: the folder that its code lies in."""


@dataclass
class ServerProcess:
    """A server in a separate process."""

    process: ForkedProgram | subprocess.Popen[bytes]
    base: str
    waits: list[float] = field(default_factory=list)
    memory: int = 0

    def request(
        self,
        path: str,
        content: bytes | None = None,
        timeout: float = 240,
        more: Mapping[str, str] | None = None,
    ) -> tuple[int, Any]:
        """Send a request; returns status and JSON."""
        headers = {"Authorization": f"Bearer {TOKEN}", **(more or {})}
        request = urllib.request.Request(f"{self.base}{path}", data=content, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=timeout) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as error:
            return error.code, json.load(error)

    def resident(self) -> int:
        """Memory of the server process, MiB."""
        text = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(text.partition("VmRSS:")[2].split()[0]) // 1024

    def sandboxes(self) -> list[int]:
        """Process ids of its sandboxes, which the process that it forks them from has; it has no workers."""
        return [sandbox for child in children(self.process.pid) for sandbox in children(child)]

    @contextmanager
    def monitored(self) -> Iterator[None]:
        """Send small requests all the time, and sample the memory."""
        done = threading.Event()

        def look() -> None:
            while not done.is_set():
                began = time.monotonic()
                assert self.request("/api/formats")[0] == 200
                self.waits.append(time.monotonic() - began)
                self.memory = max(self.memory, self.resident())
                time.sleep(0.05)

        thread = threading.Thread(target=look)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()


class PersistentConnection:
    """A persistent connection, as browsers use it; one request at a time.

    Args:
        server: returns the server for the next request.
        headers: of each request.
    """

    def __init__(self, server: Callable[[], ServerProcess], headers: Mapping[str, str]) -> None:
        self._server, self._headers = server, {"Authorization": f"Bearer {TOKEN}", **headers}
        self._base = ""
        self._connection = HTTPConnection("")

    def request(
        self, path: str, content: bytes | None = None, more: Mapping[str, str] | None = None
    ) -> tuple[int, Any, HTTPMessage]:
        """Send a request; returns status, JSON and headers.

        Raises:
            OSError, HTTPException, ValueError: there was no answer.
        """
        base = self._server().base
        if base != self._base:
            self.close()
            self._base, self._connection = base, HTTPConnection(base.removeprefix("http://"), timeout=10)
        try:
            headers = {**self._headers, **(more or {})}
            self._connection.request("GET" if content is None else "POST", path, content, headers)
            answer = self._connection.getresponse()
            return answer.status, json.loads(answer.read()), answer.headers
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the connection; the next request opens a new one."""
        self._connection.close()


def children(process: int) -> list[int]:
    try:
        tasks = list(Path(f"/proc/{process}/task").iterdir())
        return [int(one) for task in tasks for one in (task / "children").read_text().split()]
    except OSError:
        return []


def command_line(process: int) -> bytes:
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return b""


@contextmanager
def start_server(
    home: Path, more: Mapping[str, str] | None = None, before: Sequence[str] = (), *, forked: bool = False
) -> Iterator[ServerProcess]:
    """Start a server on a data folder; it is killed at the end if it still runs.

    Args:
        home: the data folder.
        more: further environment variables.
        before: a command that starts the server; none: start it directly.
        forked: whether a server of this checkout may be forked (``tests.forked_program``). It holds more memory then.
    """
    (home / "server.json").unlink(missing_ok=True)
    environment = {**os.environ, "TSR_TOKEN": TOKEN, "TSR_SAMPLE": "false", "TSR_WORKERS": "0", **(more or {})}
    words = ["review", "--home", str(home), "--port", "0", "--no-browser"]
    process: ForkedProgram | subprocess.Popen[bytes]
    if forked and TREE == ROOT:
        process = ForkedProgram("app.cli.main:run", words, environment)
    else:
        process = subprocess.Popen([*before, sys.executable, "-m", "app", *words], env=environment, cwd=TREE)
    try:
        wait_until((home / "server.json").exists, time_limit(60))
        base = json.loads((home / "server.json").read_text())["base"]
        server = ServerProcess(process, base)
        wait_until(lambda: answers(server), time_limit(30))
        yield server
    finally:
        process.kill()
        process.wait()


def answers(made: ServerProcess) -> bool:
    try:
        return made.request("/api/formats")[0] == 200
    except OSError:
        return False
