"""A browser without a network debugger.

Playwright makes the browser report every request, for which each page keeps about 4 kB per request during its whole
life. This is too much for measurements of memory over an hour. Here, only the debugging port is used, and only for
single commands.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from websockets.sync.client import connect
from websockets.sync.connection import Connection

from tsr_engine.json_shapes import JsonObject

_START_S, _TIMEOUT_S = 60.0, 120.0
"""Largest times until the browser has started, and until a condition is true, s."""


class DebugPortPage:
    """The only page of its browser.

    Attributes:
        pid: process id of the browser.
    """

    def __init__(self, pid: int, socket: Connection) -> None:
        self.pid = pid
        self._socket = socket
        self._numbers = itertools.count(1)

    def send(self, method: str, **params: object) -> JsonObject:
        """Send one command of the debugging protocol; returns its result.

        Raises:
            RuntimeError: the browser refuses the command.
        """
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while (answer := json.loads(self._socket.recv(timeout=300))).get("id") != number:
            pass  # events
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        result: JsonObject = answer["result"]
        return result

    def evaluate(self, expression: str) -> Any:  # Any: a value of JavaScript
        """The value of an expression, or of the promise that it returns.

        Raises:
            RuntimeError: the expression throws.
        """
        answer = self.send("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression[:60]}: {answer['exceptionDetails']['text']}")
        return answer["result"].get("value")

    def wait_for(self, condition: str) -> None:
        """Wait until an expression is true.

        Raises:
            TimeoutError: the expression does not become true in time.
        """
        until = time.monotonic() + _TIMEOUT_S
        while time.monotonic() < until:
            with contextlib.suppress(RuntimeError):  # the page may just be loading
                if self.evaluate(f"Boolean({condition})"):
                    return
            time.sleep(0.1)
        raise TimeoutError(f"{condition} did not come within {_TIMEOUT_S:.0f} s")


@contextlib.contextmanager
def open_debug_port_page(
    chromium: str, flags: list[str], address: str, size: tuple[int, int]
) -> Iterator[DebugPortPage]:
    """Start headless Chromium with one address.

    Args:
        chromium: path of the program.
        flags: its options.
        address: address of the page.
        size: width and height of the page, px.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [chromium, *flags, "--headless=new", "--remote-debugging-port=0", f"--user-data-dir={profile}"]
        command += [f"--window-size={size[0]},{size[1]}", address]
        with subprocess.Popen(  # noqa: S603 - the browser that was found
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as browser:
            try:
                port = _port(Path(profile) / "DevToolsActivePort")
                with connect(_target(port), max_size=None) as socket:
                    yield DebugPortPage(browser.pid, socket)
            finally:
                browser.terminate()


def _port(note: Path) -> int:
    until = time.monotonic() + _START_S
    while not (note.is_file() and note.read_text().count("\n")):
        if time.monotonic() > until:
            raise TimeoutError(f"Chromium did not start within {_START_S:.0f} s")
        time.sleep(0.1)
    return int(note.read_text().split()[0])


def _target(port: int) -> str:
    until = time.monotonic() + _START_S
    while time.monotonic() < until:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list", timeout=30) as answer:
            pages = [one for one in json.load(answer) if one["type"] == "page"]
        if pages:
            return str(pages[0]["webSocketDebuggerUrl"])
        time.sleep(0.1)
    raise TimeoutError("Chromium opened no page")
