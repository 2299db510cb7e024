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

from tests import pipeline_toys as toys
from tests.attack.editors import Place
from tests.attack.many_tracks import mot
from tests.attack.own_server import TOKEN, Running, children, command, running
from tests.attack.places import toy_place
from tests.patience import until, within

pytestmark = pytest.mark.slow


def aside(ask: Callable[[], object]) -> None:
    """Send a request in another thread."""

    def work() -> None:
        with suppress(OSError, ValueError):  # a frame is not JSON
            ask()

    threading.Thread(target=work, daemon=True).start()


def half(server: Running, head: str) -> socket.socket:
    """A connection with a partly sent request."""
    one = socket.create_connection(("127.0.0.1", int(server.base.rpartition(":")[2])), timeout=within(10))
    one.sendall(f"{head} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {TOKEN}\r\n".encode())
    return one


def below(process: int) -> list[int]:
    """All descendants of a process."""
    found = children(process)
    return found + [deeper for one in found for deeper in below(one)]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Place, Path]:
    """A data folder with a run, and a long drive that may be added."""
    folder = tmp_path_factory.mktemp("shutdown")
    (folder / "videos").mkdir()
    return toy_place(folder), toys.write_drive(folder / "videos" / "other.mp4", 2000)


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
def test_the_server_stops_within_two_seconds(made: tuple[Place, Path], tmp_path: Path, sign: signal.Signals) -> None:
    place, drive = made
    home = shutil.copytree(place.home, tmp_path / "home")
    more = {"TSR_WORKERS": "1", "TSR_ROOTS": str(drive.parent)}
    with running(home, more, forked=True) as server:
        open_ones = [
            half(server, "GET /api/events"),  # a page
            half(server, "PUT /api/uploads/a.mp4"),
            half(server, "GET /"),  # the request head never ends
        ]
        open_ones[0].sendall(b"\r\n")
        open_ones[1].sendall(b"Content-Length: 1000000\r\n\r\n\0\0\0\x20ftypisom")
        assert open_ones[0].recv(100).startswith(b"HTTP/1.1 200")
        added = server.ask("/api/videos", f'{{"path": "{drive}"}}'.encode(), more={"Content-Type": "application/json"})
        assert added[0] == 201
        run = server.ask(f"/api/videos/{place.video}/runs", b"{}", more={"Content-Type": "application/json"})[1]["id"]
        video = added[1]["id"]
        until(
            lambda: server.ask(f"/api/videos/{video}")[1]["frames"] or server.ask(f"/api/runs/{run}")[1]["frames_done"]
        )
        big, name = mot(10_000, 50), "d" * 32
        path = f"/api/videos/{place.video}/imports?as=truth&file=a.zip&name=a.zip&progress={name}"
        aside(lambda: server.ask(path, big))
        until(lambda: server.ask(f"/api/imports/{name}")[1].get("boxes", 0) > 0)
        for k in range(0, 70, 7):  # scrubbing
            aside(lambda k=k: server.ask(f"/api/videos/{place.video}/frames/{k}"))
        processes = below(server.process.pid)
        assert len(processes) >= 4, "workers, the fork server, sandboxes"
        began = time.monotonic()
        server.process.send_signal(sign)
        server.process.wait(within(2))
        assert time.monotonic() - began < within(2)
        until(lambda: not [one for one in processes if command(one)], within(2))
        for one in open_ones:
            one.close()
