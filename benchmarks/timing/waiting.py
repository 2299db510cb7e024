"""Measures how long people wait for short jobs in the tool.

``tsr review`` tracks a sample drive; then a what-if, a recording, an export and a bug bundle are requested. Without an
open page, a process starts for each job; with one, a worker stands by. One session measures both::

    python -m benchmarks.timing.waiting [--turns 3] [--video FILE]
"""

from __future__ import annotations

import argparse
import contextlib
import json
import tempfile
import threading
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Final

from sample_videos import SHIPPED
from tests.e2e.live_server import LiveServer
from tsr_engine.json_shapes import JsonObject

_CLOSED: Final = 32.0
"""Seconds until an idle process has ended."""
_OPEN: Final = 12.0
"""Seconds until a standby worker has loaded everything."""
_LOOK: Final = 0.05
"""Seconds between two polls; more frequent polls would slow the work."""
_GOING_ON: Final = ("queued", "running")


class TrackedVideo:
    """One tracked video of a server."""

    def __init__(self, server: LiveServer, video: Path) -> None:
        self._server = server
        found = server.add_video(video)
        self._run = server.call("POST", f"/videos/{found['id']}/runs", {})["id"]
        self._stop = min(300, found["frames"])
        self._asked = 0
        self._wait(f"/runs/{self._run}", 0.5)

    def seconds(self, kind: str) -> float:
        """Request a job and wait for its result; returns the seconds."""
        began = time.perf_counter()
        self._asked += 1
        if kind == "whatif":
            # Each request has new parameters, since an existing what-if is returned at once.
            changed = {"parameters": {"gate.tau": 2.0 + self._asked / 1000}}
            made = self._server.call("POST", f"/runs/{self._run}/whatif", changed)
            self._wait(f"/runs/{made['id']}", _LOOK)
        else:
            made = self._request_output(kind)
            self._wait(f"/outputs/{made['id']}", _LOOK)
        return time.perf_counter() - began

    def _request_output(self, kind: str) -> JsonObject:
        frames = {"first": 0, "stop": self._stop}
        if kind == "export":
            return dict(self._server.call("POST", "/exports", {"runs": [self._run], "format": "cvat-video"}))
        where = {"recording": "recordings", "bundle": "bundles"}[kind]
        return dict(self._server.call("POST", f"/runs/{self._run}/{where}", frames))

    def _wait(self, path: str, pause: float) -> None:
        while (now := self._server.call("GET", path))["state"] in _GOING_ON:
            time.sleep(pause)
        if now["state"] != "complete":
            raise RuntimeError(f"{path} is {now['state']}: {now.get('error')}")


@contextlib.contextmanager
def simulated_page(server: LiveServer) -> Iterator[None]:
    """Simulate an open page: a client that reads the server's events."""
    request = urllib.request.Request(server.base + "/api/events")  # noqa: S310 - our own server
    request.add_header("Authorization", "Bearer " + (server.home / "token").read_text().strip())
    with urllib.request.urlopen(request, timeout=600) as answer:  # noqa: S310

        def read() -> None:
            with contextlib.suppress(OSError, ValueError, AttributeError):
                for _ in answer:
                    pass

        threading.Thread(target=read, daemon=True).start()
        yield


def measure(video: Path, turns: int) -> JsonObject:
    """Seconds of each kind of job: without a page, with a page, and repeated right afterwards."""
    kinds = ("whatif", "recording", "export", "bundle")
    found: dict[str, dict[str, list[float]]] = {kind: {"closed": [], "open": [], "again": []} for kind in kinds}
    with tempfile.TemporaryDirectory() as home, LiveServer(Path(home), (video.parent,), sample=False) as server:
        tracked = TrackedVideo(server, video)
        for _ in range(turns):
            for kind in kinds:
                time.sleep(_CLOSED)
                found[kind]["closed"].append(tracked.seconds(kind))
        with simulated_page(server):
            time.sleep(_CLOSED)
            for turn in range(turns):
                for kind in kinds:
                    time.sleep(_OPEN if not turn else 1.0)
                    found[kind]["again" if turn else "open"].append(tracked.seconds(kind))
    return {kind: {name: round(median(v), 2) for name, v in times.items() if v} for kind, times in found.items()}


def main() -> None:
    """Print the table as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--video", type=Path, default=SHIPPED[0].video)
    args = parser.parse_args()
    print(json.dumps(measure(args.video.absolute(), args.turns), indent=1))


if __name__ == "__main__":
    main()
