"""A served run, and a client of viser's page: its socket, messages and clicks."""

from __future__ import annotations

import secrets
import socket
import time
from collections.abc import Iterator
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
from tests.app.threaded_server import ThreadedServer
from tests.app.toy_home import ToyHome
from tests.app.toy_server import SECRET, Server

PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
HEAD_TIMEOUT_S = 2.0
"""Deadline for the heads of requests, s."""
MAX_WAIT_S = 90.0
"""The longest wait of a test, s: a slow machine may need it, and the wait ends as soon as the result arrives."""
AUTHORISED = {"Authorization": f"Bearer {SECRET}"}


@dataclass
class Scene3dClient:
    """A server with the toy run."""

    server: ThreadedServer
    run: str
    video: str

    @property
    def scene3d(self) -> Any:
        return self.server.server.context.scene3d

    def call(self, method: str, path: str, **options: Any) -> requests.Response:
        """Send a request with credentials."""
        return requests.request(method, self.server.url + path, headers=AUTHORISED, timeout=MAX_WAIT_S, **options)

    def name(self) -> str:
        """A name for a new view."""
        return secrets.token_hex(8)

    def socket(
        self, view: str, headers: dict[str, str] | None = None, slash: str = "", **options: Any
    ) -> ClientConnection:
        """Open the socket of a view, as viser's page does."""
        address = f"ws://127.0.0.1:{self.server.port}/viser/{self.run}/{view}{slash}"
        given = {**AUTHORISED, "Origin": self.server.url} if headers is None else headers
        values = {
            "subprotocols": [PROTOCOL],
            "max_size": 2**26,
            "compression": None,
            "open_timeout": MAX_WAIT_S,
            **options,
        }
        return connect(address, additional_headers=given, proxy=None, **values)


def is_closed(port: int) -> bool:
    """Whether a port of loopback is closed."""
    with socket.socket() as line:
        line.settimeout(2)
        return line.connect_ex(("127.0.0.1", port)) != 0


def read_until(socket: ClientConnection, wanted: bytes, seconds: float = MAX_WAIT_S) -> bytes:
    """Read messages until one contains a text; returns that message's text."""
    return read_all_until(socket, wanted, seconds)[-1]


def read_all_until(socket: ClientConnection, wanted: bytes, seconds: float = MAX_WAIT_S) -> list[bytes]:
    """Read messages until one contains a text; returns the texts of all."""
    end, found = time.monotonic() + seconds, [b""]
    while wanted not in found[-1]:
        found.append(decoded(socket.recv(timeout=max(0.01, end - time.monotonic()))))
    return found


def read_to_the_end(socket: ClientConnection, seconds: float = MAX_WAIT_S) -> None:
    """Read messages until the server closes the connection."""
    for _ in range(1000):
        socket.recv(timeout=seconds)


def decoded(message: Any) -> bytes:
    """The names and texts in a message of viser."""
    assert isinstance(message, bytes)
    size, packed = int.from_bytes(message[:8], "little"), int.from_bytes(message[8:16], "little")
    return zstandard.ZstdDecompressor().decompress(message[16 : 16 + packed], max_output_size=size)


def send_message(socket: ClientConnection, kind: str, **facts: Any) -> None:
    """Send a message as viser's page."""
    socket.send(msgspec.msgpack.encode({"type": kind, **facts}))


def send_camera(socket: ClientConnection) -> None:
    """Send the camera's position, the first message of viser's page."""
    unit = {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0), "look_at": (0.0, 1.0, 0.0)}
    facts = {"fov": 1.0, "near": 0.01, "far": 1e3, "image_height": 480, "image_width": 640}
    send_message(socket, "ViewerCameraMessage", **unit, up_direction=(0.0, 0.0, 1.0), **facts)


class SocketServer(ThreadedServer):
    """A served application with sockets, as ``tsr review`` serves it."""

    def __init__(self, server: Server) -> None:
        super().__init__(server)
        self.uvicorn = ReviewServer(
            server_config(server.app, ConnectionLimits(head=HEAD_TIMEOUT_S), log_level="critical")
        )
        self.thread = type(self.thread)(target=self.uvicorn.run, kwargs={"sockets": [self.listener]}, daemon=True)


@contextmanager
def open_client(toy: ToyHome) -> Iterator[Scene3dClient]:
    """Serve a toy home."""
    server = SocketServer(Server(toy.settings.home, roots=(toy.video.parent,)))
    server.start()
    try:
        yield Scene3dClient(server, toy.run_id, toy.video_id)
    finally:
        if server.thread.is_alive():
            server.stop()
