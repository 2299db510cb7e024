"""Ctrl-C is answered within two seconds during any work, and nothing continues after it."""

from __future__ import annotations

import shutil
import signal
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from tests import toy_pipeline
from tests.attack.concurrent_editors import TrackedLibrary
from tests.attack.libraries import toy_library
from tests.attack.many_tracks import mot_archive
from tests.attack.server_process import TOKEN, ServerProcess, children, command_line, start_server
from tests.waiting import time_limit, wait_until

pytestmark = pytest.mark.slow


def send_in_thread(ask: Callable[[], object]) -> None:
    """Send a request in another thread."""

    def work() -> None:
        with suppress(OSError, ValueError):  # a frame is not JSON
            ask()

    threading.Thread(target=work, daemon=True).start()


def half_request(server: ServerProcess, head: str) -> socket.socket:
    """A connection with a partly sent request."""
    one = socket.create_connection(("127.0.0.1", int(server.base.rpartition(":")[2])), timeout=time_limit(10))
    one.sendall(f"{head} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {TOKEN}\r\n".encode())
    return one


def descendants(process: int) -> list[int]:
    """All descendants of a process."""
    found = children(process)
    return found + [deeper for one in found for deeper in descendants(one)]


@pytest.fixture(scope="module")
def library_and_drive(tmp_path_factory: pytest.TempPathFactory) -> tuple[TrackedLibrary, Path]:
    """A data folder with a run, and a long drive that may be added."""
    folder = tmp_path_factory.mktemp("shutdown")
    (folder / "videos").mkdir()
    return toy_library(folder), toy_pipeline.write_drive(folder / "videos" / "other.mp4", 1000)


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
def test_the_server_stops_within_two_seconds(
    library_and_drive: tuple[TrackedLibrary, Path], tmp_path: Path, sign: signal.Signals
) -> None:
    library, drive = library_and_drive
    home = shutil.copytree(library.home, tmp_path / "home")
    more = {"TSR_WORKERS": "1", "TSR_ROOTS": str(drive.parent)}
    with start_server(home, more, forked=True) as server:
        open_ones = [
            half_request(server, "GET /api/events"),  # a page
            half_request(server, "PUT /api/uploads/a.mp4"),
            half_request(server, "GET /"),  # the request head never ends
        ]
        open_ones[0].sendall(b"\r\n")
        open_ones[1].sendall(b"Content-Length: 1000000\r\n\r\n\0\0\0\x20ftypisom")
        assert open_ones[0].recv(100).startswith(b"HTTP/1.1 200")
        added = server.request(
            "/api/videos", f'{{"path": "{drive}"}}'.encode(), more={"Content-Type": "application/json"}
        )
        assert added[0] == 201
        run = server.request(f"/api/videos/{library.video}/runs", b"{}", more={"Content-Type": "application/json"})[1][
            "id"
        ]
        video = added[1]["id"]
        wait_until(
            lambda: (
                server.request(f"/api/videos/{video}")[1]["frames"]
                or server.request(f"/api/runs/{run}")[1]["frames_done"]
            )
        )
        big, name = mot_archive(5_000, 50), "d" * 32
        path = f"/api/videos/{library.video}/imports?as=truth&file=a.zip&name=a.zip&progress={name}"
        send_in_thread(lambda: server.request(path, big))
        wait_until(lambda: server.request(f"/api/imports/{name}")[1].get("boxes", 0) > 0)
        for k in range(0, 70, 7):  # scrubbing
            send_in_thread(lambda k=k: server.request(f"/api/videos/{library.video}/frames/{k}"))
        processes = descendants(server.process.pid)
        assert len(processes) >= 4, "workers, the fork server, sandboxes"
        began = time.monotonic()
        server.process.send_signal(sign)
        server.process.wait(time_limit(2))
        assert time.monotonic() - began < time_limit(2)
        wait_until(lambda: not [one for one in processes if command_line(one)], time_limit(2))
        for one in open_ones:
            one.close()
