"""A served run, and viser's page from the server's side: its socket, messages and clicks."""

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
import uvicorn
import viser
import zstandard
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from app.cli.serve import ReviewServer
from tests.app.live_server import Live
from tests.app.toy_home import ToyHome
from tests.app.toy_server import SECRET, Server

PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
PATIENCE = 90.0
"""The longest wait of a test, s: a slow machine may need it, and the wait ends as soon as the result arrives."""
AUTHORISED = {"Authorization": f"Bearer {SECRET}"}


def until(found: Callable[[], Any], seconds: float = PATIENCE) -> Any:
    """The result of ``found`` as soon as it is true."""
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
        """The service behind it."""
        return self.live.server.context.scene3d

    def call(self, method: str, path: str, **options: Any) -> requests.Response:
        """A request with credentials."""
        return requests.request(method, self.live.url + path, headers=AUTHORISED, timeout=PATIENCE, **options)

    def name(self) -> str:
        """A name for a new view."""
        return secrets.token_hex(8)

    def socket(
        self, view: str, headers: dict[str, str] | None = None, slash: str = "", **options: Any
    ) -> ClientConnection:
        """The socket of a view, as viser's page opens it."""
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
    """Whether nobody listens on a port of loopback."""
    with socket.socket() as line:
        line.settimeout(2)
        return line.connect_ex(("127.0.0.1", port)) != 0


def read_until(socket: ClientConnection, wanted: bytes, seconds: float = PATIENCE) -> bytes:
    """Take messages until one contains a text; the text of that one."""
    return read_all_until(socket, wanted, seconds)[-1]


def read_all_until(socket: ClientConnection, wanted: bytes, seconds: float = PATIENCE) -> list[bytes]:
    """The texts of all messages up to the one that contains a text."""
    end, found = time.monotonic() + seconds, [b""]
    while wanted not in found[-1]:
        found.append(reported(socket.recv(timeout=max(0.01, end - time.monotonic()))))
    return found


def read_to_the_end(socket: ClientConnection, seconds: float = PATIENCE) -> None:
    """Take messages until the connection is closed from the other side."""
    for _ in range(1000):
        socket.recv(timeout=seconds)


def reported(message: Any) -> bytes:
    """The part of a message of viser that holds names and texts."""
    assert isinstance(message, bytes)
    size, packed = int.from_bytes(message[:8], "little"), int.from_bytes(message[8:16], "little")
    return zstandard.ZstdDecompressor().decompress(message[16 : 16 + packed], max_output_size=size)


def say(socket: ClientConnection, kind: str, **facts: Any) -> None:
    """Send what viser's page would send."""
    socket.send(msgspec.msgpack.encode({"type": kind, **facts}))


def look(socket: ClientConnection) -> None:
    """The first thing that viser's page sends: where its camera is."""
    unit = {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0), "samples_at": (0.0, 1.0, 0.0)}
    facts = {"fov": 1.0, "near": 0.01, "far": 1e3, "image_height": 480, "image_width": 640}
    say(socket, "ViewerCameraMessage", **unit, up_direction=(0.0, 0.0, 1.0), **facts)


class SocketLive(Live):
    """A served application, sockets and all, as ``tsr review`` serves it."""

    def __init__(self, server: Server) -> None:
        super().__init__(server)
        config = uvicorn.Config(server.app, log_level="critical", timeout_graceful_shutdown=2, lifespan="on")
        self.uvicorn = ReviewServer(config)
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
