"""A real server in its own process on a data folder, for tests and screenshots."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Protocol

from sample_videos import SHIPPED

MAX_START_S = 240
"""The longest start of the server on a busy machine, s."""
POLL_INTERVAL_S = 0.25
"""Interval of requests while waiting for the server, s: each costs it 15 ms."""
_LINK = re.compile(r"(http://[^/\s]+)/login/\S+")


class Process(Protocol):
    """The part of ``subprocess.Popen`` that a server needs."""

    @property
    def pid(self) -> int: ...
    def poll(self) -> int | None: ...
    def terminate(self) -> None: ...
    def kill(self) -> None: ...
    def wait(self, timeout: float | None = None) -> int: ...


class LiveServer:
    """``tsr review`` as a user starts it, on a free port; a context manager.

    Args:
        home: data folder.
        roots: folders that videos may be added from; default: the samples'.
        sample: whether the library begins with the sample drives.
        code: checkout of the project that is served; None: this one.
    """

    def __init__(
        self,
        home: Path,
        roots: tuple[Path, ...] = (SHIPPED[0].video.parent,),
        *,
        sample: bool = True,
        code: Path | None = None,
    ) -> None:
        self.home = home
        self._roots = roots
        self._code = code
        self._sample = "--sample" if sample else "--no-sample"
        self._process: Process | None = None
        self.base = ""
        self._log = home / "server.log"

    @property
    def pid(self) -> int:
        """Process number of the server.

        Raises:
            RuntimeError: it is not running.
        """
        if self._process is None:
            raise RuntimeError("The server does not run.")
        return self._process.pid

    def __enter__(self) -> LiveServer:
        try:
            self.start()
        except BaseException:
            self.stop()  # a server that was too slow must not stay
            raise
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.stop()

    def start(self, port: int = 0) -> None:
        """Start and wait until it answers."""
        command = ["review", "--home", str(self.home), "--port", str(port), "--no-browser", self._sample]
        for root in self._roots:
            command += ["--root", str(root)]
        with self._log.open("wb") as log:
            self._process = self._begin(command, log)
        found = None
        end = time.monotonic() + MAX_START_S
        while found is None:
            if self._process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"The server did not start: {self._log.read_text()}")
            time.sleep(0.1)
            found = _LINK.search(self._log.read_text())
        self.base = found.group(1)
        while True:
            try:
                self.call("GET", "/session")
            except (urllib.error.URLError, ConnectionError):  # the link is printed a moment before it answers
                if self._process.poll() is not None or time.monotonic() > end:
                    raise
                time.sleep(0.1)
            else:
                return

    def _begin(self, command: Sequence[str], log: IO[bytes]) -> Process:
        """The process of a ``tsr`` command."""
        start = [sys.executable, "-c", "import sys; from app.cli.main import run; sys.exit(run())"]
        return subprocess.Popen([*start, *command], stdout=log, stderr=subprocess.STDOUT, cwd=self._code)

    def stop(self) -> None:
        """Stop it, as Ctrl-C does."""
        if self._process is not None:
            self._process.terminate()
            try:
                self._process.wait(20)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None

    def kill(self) -> None:
        """Kill it, as a power failure does."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def link(self) -> str:
        """A new one-time URL of the page."""
        return self.base + str(self.call("POST", "/session/links")["path"])

    def call(self, method: str, path: str, body: bytes | dict[str, Any] | None = None, type_: str | None = None) -> Any:
        """Send an API request with the server's token; returns the JSON of the answer."""
        data = json.dumps(body).encode() if isinstance(body, dict) else body
        request = urllib.request.Request(self.base + "/api" + path, data=data, method=method)
        request.add_header("Authorization", "Bearer " + (self.home / "token").read_text().strip())
        if data is not None:
            request.add_header("Content-Type", type_ or "application/json")
        with urllib.request.urlopen(request, timeout=60) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def add_video(self, path: Path, timeout: float = 300) -> dict[str, Any]:
        """Add a video of one of the folders and wait for the end of its import.

        Raises:
            RuntimeError: the import failed or did not end.
        """
        video = self.call("POST", "/videos", {"path": str(path)})["id"]
        end = time.monotonic() + timeout
        while (now := self.call("GET", f"/videos/{video}"))["state"] != "ready":
            if now["state"] == "failed" or time.monotonic() > end:
                raise RuntimeError(f"The import of {path.name} failed or took over {timeout:.0f} s: {now}")
            time.sleep(POLL_INTERVAL_S)
        return dict(now)

    def track(self, video: str, request: dict[str, Any], timeout: float = 500) -> str:
        """Run the engine over a video and wait for the end; returns the id of the run.

        Args:
            video: its id.
            request: parameters of the request, such as ``{"stop": 120}``.

        Raises:
            RuntimeError: the run failed or did not end.
        """
        run = str(self.call("POST", f"/videos/{video}/runs", request)["id"])
        end = time.monotonic() + timeout
        while (now := self.call("GET", f"/runs/{run}"))["state"] != "complete":
            if now["state"] == "failed" or time.monotonic() > end:
                raise RuntimeError(f"The run failed or took over {timeout:.0f} s: {now}")
            time.sleep(POLL_INTERVAL_S)
        return run

    def wait_for_run(self, name: str, timeout: float = 240) -> dict[str, Any]:
        """Wait until the newest run of the video with this name is complete; returns the video."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            videos = self.call("GET", "/videos")["videos"]
            video = next((one for one in videos if one["name"] == name), None)
            if video and video["latest_run"]:
                run = self.call("GET", f"/runs/{video['latest_run']}")
                if run["state"] == "complete":
                    return dict(video)
                if run["state"] == "failed":
                    raise RuntimeError(f"The run of {name} failed: {run['error']}")
            time.sleep(POLL_INTERVAL_S)
        raise RuntimeError(f"{name} had no complete run after {timeout} s")
