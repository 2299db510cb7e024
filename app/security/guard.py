"""The guard: checks every request and every socket before any route.

It checks in this order: the Host header (against DNS rebinding), the origin of requests that change something, the
caller (``app.security.access``), the size of the body. ``app.api.access`` checks the caller's rights. Every answer gets
security headers; answers to accepted callers also say how long they took (``Server-Timing``).
"""

from __future__ import annotations

import ipaddress
import json
import re
import time
from collections.abc import Iterable
from typing import Final

from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.errors import RETRY_AFTER, error_body
from app.security.access import Access, Denied
from app.storage.database import storage_failure

CSP: Final = (
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self'; script-src 'self'; connect-src 'self'; "
    "frame-src 'self'; object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_SAFE_METHODS: Final = frozenset({"GET", "HEAD", "OPTIONS"})
_PUBLIC_PREFIXES: Final = ("/login/", "/static/")
_PUBLIC_PATHS: Final = frozenset({"/", "/favicon.ico", "/index.html", "/sign-in"})
_SIGN_IN: Final = ("POST", "/api/session")
_UPLOADS: Final = re.compile(r"/api/(uploads/.*|videos/[0-9a-f]{64}/imports|bundles)", re.ASCII | re.DOTALL)
"""Routes that stream their body to a file, with a separate limit."""
_MAX_LENGTH_DIGITS: Final = 18


class Guard:
    """ASGI middleware that accepts or refuses every connection.

    Args:
        app: the application behind it.
        access: identifies the caller.
        hosts: allowed names of the Host header besides loopback's, without port.
        body_max: maximum size of a request's body except uploads, bytes.
    """

    def __init__(self, app: ASGIApp, access: Access, hosts: Iterable[str], body_max: int) -> None:
        self.app = app
        self.access = access
        self.hosts = frozenset({"127.0.0.1", "localhost", "[::1]", *(name.lower() for name in hosts)})
        self.body_max = body_max

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve or refuse one connection."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        began = time.perf_counter()
        if self.access.proxies.is_tls(scope):
            scope["scheme"] = "wss" if scope["type"] == "websocket" else "https"
        refusal = self._origin_error(scope) or await self._authentication_error(scope) or self._size_error(scope)
        if refusal is not None:
            await _refuse(scope, send, *refusal)
            return
        if scope["type"] == "websocket":
            await self.app(scope, receive, send)
            return
        body = _LimitedBody(receive, None if _UPLOADS.fullmatch(scope["path"]) else self.body_max)
        answered = False

        async def send_guarded(message: Message) -> None:
            nonlocal answered
            if message["type"] == "http.response.start":
                if body.exceeded:
                    return
                answered = True
                headers = MutableHeaders(scope=message)
                headers["Server-Timing"] = f"total;dur={1000 * (time.perf_counter() - began):.1f}"
                _set_security_headers(headers)
            elif body.exceeded and not answered:
                return
            await send(message)

        await self.app(scope, body, send_guarded)
        if body.exceeded and not answered:
            await _refuse(scope, send, 413, "too_large", f"The body is larger than {self.body_max} bytes.")

    def _origin_error(self, scope: Scope) -> tuple[int, str, str] | None:
        """The error for a request for another host, or from another site; None: there is none."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        name = _without_port(host)
        if len(headers.getlist("host")) != 1 or not (name in self.hosts or (name and name == _server_address(scope))):
            message = (
                "This server does not answer under that name. Open the address that it printed, or add the name to "
                "TSR_ALLOWED_HOSTS."
            )
            return 400, "bad_host", message
        unsafe = scope["type"] == "websocket" or scope["method"] not in _SAFE_METHODS
        if unsafe and not _same_origin(headers, host, scope["scheme"]):
            return 403, "bad_origin", "The request comes from another page. Use the page of this server."
        return None

    async def _authentication_error(self, scope: Scope) -> tuple[int, str, str] | None:
        """The error for a request without a known caller; None: there is none."""
        path = scope["path"]
        if path in _PUBLIC_PATHS or path.startswith(_PUBLIC_PREFIXES) or (scope.get("method"), path) == _SIGN_IN:
            return None
        try:
            await self.access.authenticate(scope)
        except Denied as denied:
            return denied.status, denied.code, denied.message
        except PoolTimeout:
            return 503, "database_busy", "Too many requests wait for the database. This one can be repeated."
        except DBAPIError as error:
            failure = storage_failure(error)
            if failure is None:
                raise
            return failure.status, failure.code, failure.message
        return None

    def _size_error(self, scope: Scope) -> tuple[int, str, str] | None:
        """The error for a body that is too large; None: there is none."""
        path = scope["path"]
        length = Headers(scope=scope).get("content-length", "0")
        if len(length) > _MAX_LENGTH_DIGITS or not (length.isascii() and length.isdigit()):
            return 400, "bad_request", "The header Content-Length is not the number of bytes of the body."
        if not _UPLOADS.fullmatch(path) and int(length) > self.body_max:
            return 413, "too_large", f"The body has {length} bytes; the limit is {self.body_max}."
        return None


class _LimitedBody:
    """``receive`` that ends a body at a limit."""

    def __init__(self, receive: Receive, max_bytes: int | None) -> None:
        self._receive = receive
        self._max_bytes = max_bytes
        self._received = 0
        self.exceeded = False

    async def __call__(self) -> Message:
        message = await self._receive()
        if message["type"] == "http.request" and self._max_bytes is not None:
            self._received += len(message.get("body", b""))
            if self._received > self._max_bytes:
                self.exceeded = True
                return {"type": "http.disconnect"}
        return message


def _without_port(host: str) -> str:
    if host.startswith("["):
        name, bracket, port = host.partition("]")
        if not bracket or (port and not port.startswith(":")):
            return ""
        name, port = name + "]", port.removeprefix(":")
    else:
        name, _, port = host.partition(":")
    return name.lower() if not port or (port.isascii() and port.isdigit()) else ""


def _same_origin(headers: Headers, host: str, served: str) -> bool:
    if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
        return False
    origin = headers.get("origin")
    if origin is None:
        return True
    # An origin is scheme://host; anything else is refused. (urlsplit raises for some of it.) A TLS proxy
    # need not announce itself, so https is allowed too; a change from https to http is not.
    scheme, _, name = origin.lower().partition("://")
    allowed_schemes = ("https",) if served in ("https", "wss") else ("http", "https")
    return scheme in allowed_schemes and name == host.lower()


def _server_address(scope: Scope) -> str:
    """The server's address that a client has connected to; pages of other sites cannot have it as their host."""
    try:
        address = ipaddress.ip_address((scope.get("server") or ("",))[0])
    except ValueError:
        return ""
    if isinstance(address, ipaddress.IPv6Address):
        return f"[{address}]" if address.ipv4_mapped is None else str(address.ipv4_mapped)
    return str(address)


def _set_security_headers(headers: MutableHeaders) -> None:
    headers.setdefault("Content-Security-Policy", CSP)
    headers["X-Content-Type-Options"] = "nosniff"
    headers["Referrer-Policy"] = "no-referrer"
    headers["Cross-Origin-Resource-Policy"] = "same-origin"
    headers["Cross-Origin-Opener-Policy"] = "same-origin"
    headers.setdefault("Cache-Control", "no-store")


async def _refuse(scope: Scope, send: Send, status: int, code: str, message: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 4000 + status, "reason": code})
        return
    body = json.dumps(error_body(code, message)).encode()
    start: Message = {
        "type": "http.response.start",
        "status": status,
        "headers": [(b"content-type", b"application/json"), (b"content-length", str(len(body)).encode())],
    }
    if status == 503:
        start["headers"].append((b"retry-after", RETRY_AFTER.encode()))
    _set_security_headers(MutableHeaders(scope=start))
    await send(start)
    await send({"type": "http.response.body", "body": b"" if scope.get("method") == "HEAD" else body})
