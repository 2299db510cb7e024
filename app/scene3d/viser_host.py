"""A viser server that only this program can reach.

viser has no access check: every client that finds its port gets the scene. This server listens on loopback and refuses
every request without a secret that never leaves this process. viser has no setting for that, so its call of
``websockets.asyncio.server.serve`` gets one more check while it starts. Each start tests the check, and stops a viser
without it at once.
"""

from __future__ import annotations

import hmac
import secrets
import socket
import sys
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import rich

from tsr_engine.errors import StorageError
from tsr_engine.extras import explained

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

    _Check = Callable[[ServerConnection, Request], Awaitable[Response | None] | Response | None]

HEADER: Final = "X-Tsr-Space"
"""Header with the secret."""
_STARTING = threading.Lock()


class ViserHost:
    """One viser server on a free loopback port.

    Raises:
        MissingExtra: viser is not installed.
        StorageError: it cannot be started, or accepts requests without the secret.
    """

    def __init__(self, label: str) -> None:
        with explained():
            import viser

        self.secret = secrets.token_urlsafe(24)
        with _STARTING, _without_viser_output(), _checked(self.secret):
            self.server: viser.ViserServer = viser.ViserServer(host="127.0.0.1", port=0, label=label, verbose=False)
        self.port = self.server.get_port()
        # The page could request a tunnel to a server of viser's makers; disable it.
        self.server.request_share_url = _no_share  # type: ignore[method-assign]
        if not refuses_strangers(self.port):
            self.stop()
            raise StorageError(
                "This version of viser shows scenes to everybody. Install the version that tsr needs: "
                "pip install 'tsr[scene3d]'."
            )

    def stop(self) -> None:
        """Close all connections and free the port; safe to call again."""
        with _STARTING, _without_viser_output():
            self.server.stop()


def _no_share(verbose: bool = True) -> str | None:
    return None


@contextmanager
def _checked(secret: str) -> Iterator[None]:
    """Within this block, servers that viser starts with ``websockets`` refuse requests without the secret."""
    import websockets.asyncio.server as library

    given = library.serve

    def serve(*args: Any, process_request: _Check | None = None, **options: Any) -> object:  # Any: as viser gives them
        def check(connection: ServerConnection, request: Request) -> Awaitable[Response | None] | Response | None:
            sent = request.headers.get_all(HEADER)
            if len(sent) != 1 or not hmac.compare_digest(sent[0].encode(), secret.encode()):
                return connection.respond(403, "This port is private to tsr.\n")
            return None if process_request is None else process_request(connection, request)

        return given(*args, process_request=check, **options)

    library.serve = serve  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        library.serve = given  # type: ignore[misc]


@contextmanager
def _without_viser_output() -> Iterator[None]:
    """Within this block viser prints nothing; other output is not affected."""
    given = rich.print

    def reported(*args: Any, **options: Any) -> None:  # Any: what rich.print takes
        if not sys._getframe(1).f_globals.get("__name__", "").startswith("viser."):
            given(*args, **options)

    rich.print = reported
    try:
        yield
    finally:
        rich.print = given


def refuses_strangers(port: int) -> bool:
    """Whether a request without the secret is refused."""
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=5) as line:
            line.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n")
            return line.recv(64).startswith(b"HTTP/1.1 403")
    except OSError:
        return False
