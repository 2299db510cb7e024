"""A served run, and a client of viser's page: its socket, messages and clicks."""

from __future__ import annotations

import secrets
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import msgspec
import requests
import viser
import zstandard
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from app.cli.serve import ReviewServer, server_config
from app.security.connections import ConnectionLimits
from tests.app.live_server import Live
from tests.app.toy_home import ToyHome
from tests.app.toy_server import SECRET, Server

PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
HEAD = 2.0
"""Deadline for the heads of requests, s."""
PATIENCE = 90.0
"""The longest wait of a test, s: a slow machine may need it, and the wait ends as soon as the result arrives."""
AUTHORISED = {"Authorization": f"Bearer {SECRET}"}


def until(found: Callable[[], Any], seconds: float = PATIENCE) -> Any:
    """Wait until ``found`` returns a true value; returns it."""
    end = time.monotonic() + seconds
    while True:
        value = found()
        if value:
            return value
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)


@dataclass
class Desk:
    """A server with the toy run."""

    live: Live
    run: str
    video: str

    @property
    def scene3d(self) -> Any:
        return self.live.server.context.scene3d

    def call(self, method: str, path: str, **options: Any) -> requests.Response:
        """Send a request with credentials."""
        return requests.request(method, self.live.url + path, headers=AUTHORISED, timeout=PATIENCE, **options)

    def name(self) -> str:
        """A name for a new view."""
        return secrets.token_hex(8)

    def socket(
        self, view: str, headers: dict[str, str] | None = None, slash: str = "", **options: Any
    ) -> ClientConnection:
        """Open the socket of a view, as viser's page does."""
        address = f"ws://127.0.0.1:{self.live.port}/viser/{self.run}/{view}{slash}"
        given = {**AUTHORISED, "Origin": self.live.url} if headers is None else headers
        values = {
            "subprotocols": [PROTOCOL],
            "max_size": 2**26,
            "compression": None,
            "open_timeout": PATIENCE,
            **options,
        }
        return connect(address, additional_headers=given, proxy=None, **values)


def is_closed(port: int) -> bool:
    """Whether a port of loopback is closed."""
    with socket.socket() as line:
        line.settimeout(2)
        return line.connect_ex(("127.0.0.1", port)) != 0


def read_until(socket: ClientConnection, wanted: bytes, seconds: float = PATIENCE) -> bytes:
    """Read messages until one contains a text; returns that message's text."""
    return read_all_until(socket, wanted, seconds)[-1]


def read_all_until(socket: ClientConnection, wanted: bytes, seconds: float = PATIENCE) -> list[bytes]:
    """Read messages until one contains a text; returns the texts of all."""
    end, found = time.monotonic() + seconds, [b""]
    while wanted not in found[-1]:
        found.append(reported(socket.recv(timeout=max(0.01, end - time.monotonic()))))
    return found


def read_to_the_end(socket: ClientConnection, seconds: float = PATIENCE) -> None:
    """Read messages until the server closes the connection."""
    for _ in range(1000):
        socket.recv(timeout=seconds)


def reported(message: Any) -> bytes:
    """The names and texts in a message of viser."""
    assert isinstance(message, bytes)
    size, packed = int.from_bytes(message[:8], "little"), int.from_bytes(message[8:16], "little")
    return zstandard.ZstdDecompressor().decompress(message[16 : 16 + packed], max_output_size=size)


def say(socket: ClientConnection, kind: str, **facts: Any) -> None:
    """Send a message as viser's page."""
    socket.send(msgspec.msgpack.encode({"type": kind, **facts}))


def look(socket: ClientConnection) -> None:
    """Send the camera's position, the first message of viser's page."""
    unit = {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0), "look_at": (0.0, 1.0, 0.0)}
    facts = {"fov": 1.0, "near": 0.01, "far": 1e3, "image_height": 480, "image_width": 640}
    say(socket, "ViewerCameraMessage", **unit, up_direction=(0.0, 0.0, 1.0), **facts)


class SocketLive(Live):
    """A served application with sockets, as ``tsr review`` serves it."""

    def __init__(self, server: Server) -> None:
        super().__init__(server)
        self.uvicorn = ReviewServer(server_config(server.app, ConnectionLimits(head=HEAD), log_level="critical"))
        self.thread = type(self.thread)(target=self.uvicorn.run, kwargs={"sockets": [self.listener]}, daemon=True)


@contextmanager
def open_desk(toy: ToyHome) -> Iterator[Desk]:
    """Serve a toy home."""
    live = SocketLive(Server(toy.settings.home, roots=(toy.video.parent,)))
    live.start()
    try:
        yield Desk(live, toy.run_id, toy.video_id)
    finally:
        if live.thread.is_alive():
            live.stop()
