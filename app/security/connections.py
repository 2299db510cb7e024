"""Connections: strict HTTP parsing, deadlines, and a cap on their number.

``h11`` accepts what other parsers read differently: lines that end in a bare LF, header lines that continue on the next
line, ``Content-Length`` beside ``Transfer-Encoding``. Behind a proxy two readings of the same bytes are two different
requests. Such a request is answered with 400, and its connection is closed.

``tests/attack/test_connections.py`` tests the parts of ``h11`` and ``uvicorn`` that are overridden here.
"""

from __future__ import annotations

import asyncio
import json
import re
import resource
from typing import Final, Literal

import h11
from h11._receivebuffer import ReceiveBuffer
from uvicorn.config import Config
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.server import ServerState

from app.errors import error_body
from tsr_engine.json_shapes import JsonObject

HEAD_TIMEOUT_S: Final = 10.0
"""Seconds from the first byte (or the connection) to the end of a request's head."""
BODY_IDLE_TIMEOUT_S: Final = 60.0
"""Seconds without a byte after which an expected body counts as interrupted."""
READ_IDLE_TIMEOUT_S: Final = 60.0
"""Seconds that the client may take to read the next piece of a response."""
_MAX_FILE_DESCRIPTORS: Final = 4096
"""File descriptors that the server requests, if the system allows as many."""
_MAX_CONNECTIONS: Final = 1000
"""Maximum number of connections, even with more descriptors."""
_HEAD_ENDS: Final = re.compile(rb"\n\r?\n")
_BARE_LF: Final = re.compile(rb"(?<!\r)\n")
_FOLDED: Final = re.compile(rb"\n[ \t]")
_CHUNK: Final = re.compile(rb"[0-9A-Fa-f]{1,16}(;[^\r\n]*)?\r\n")
_Phase = Literal["head", "body", "rest"]


class ConnectionLimits:
    """State shared by the connections of one server. ``protocol`` is for ``uvicorn.Config(http=...)``.

    Args:
        max_connections: maximum number of connections; unset: as many as leave half of the descriptors to the database
            and to files.
        head: seconds for the head of a request, see ``HEAD_TIMEOUT_S``.
    """

    def __init__(self, max_connections: int | None = None, head: float = HEAD_TIMEOUT_S) -> None:
        self.max_connections = (
            min(_MAX_CONNECTIONS, _descriptors() // 2) if max_connections is None else max_connections
        )
        self.head = head
        self.waiting: dict[_StrictHttp, None] = {}
        """Connections without a complete head so far, oldest first."""

    def protocol(
        self,
        config: Config,
        server_state: ServerState,
        app_state: JsonObject,
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> asyncio.Protocol:
        """One connection."""
        return _StrictHttp(self, config, server_state, app_state, _loop)


def _descriptors() -> int:
    """Number of descriptors of this process, after requesting as many as it needs."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = _MAX_FILE_DESCRIPTORS if hard == resource.RLIM_INFINITY else min(_MAX_FILE_DESCRIPTORS, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
        return wanted
    return _MAX_FILE_DESCRIPTORS if soft == resource.RLIM_INFINITY else soft


class _StrictHttp(H11Protocol):
    """One connection; it has a deadline whenever it waits for the client."""

    def __init__(
        self,
        limits: ConnectionLimits,
        config: Config,
        server_state: ServerState,
        app_state: JsonObject,
        loop: asyncio.AbstractEventLoop | None,
    ) -> None:
        super().__init__(config, server_state, app_state, loop)
        self.conn._receive_buffer = _StrictBuffer()
        self._limits = limits
        self._phase: _Phase | None = None
        self._upgraded = False
        self._deadline: asyncio.TimerHandle | None = None
        self._write_deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        if len(self.connections) > self._limits.max_connections:
            # Drop connections without a request first, so that silent connections cannot block others.
            dropped = next(iter(self._limits.waiting), self)
            self.connections.discard(dropped)
            self._limits.waiting.pop(dropped, None)
            dropped.transport.abort()
            if dropped is self:
                return
        self._update_deadline()

    def connection_lost(self, exc: Exception | None) -> None:
        self._limits.waiting.pop(self, None)
        self._cancel_deadline()
        if self._write_deadline is not None:
            self._write_deadline.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self._phase == "body":
            self._cancel_deadline()
        self._update_deadline()

    def handle_events(self) -> None:
        super().handle_events()
        self._update_deadline()

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._update_deadline()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        self._upgraded = True  # another protocol has the connection from now on
        self._update_deadline()
        super().handle_websocket_upgrade(event)

    def pause_writing(self) -> None:
        super().pause_writing()
        self._write_deadline = self.loop.call_later(READ_IDLE_TIMEOUT_S, self.transport.abort)

    def resume_writing(self) -> None:
        super().resume_writing()
        if self._write_deadline is not None:
            self._write_deadline.cancel()
            self._write_deadline = None

    def send_400_response(self, msg: str) -> None:
        """Refuse invalid HTTP with the common error shape, unless a response has started."""
        if self.cycle is not None:
            self.cycle.disconnected = True  # nobody reads another answer
            self.cycle.message_event.set()
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE):
            message = "This is not a valid HTTP request. The connection was closed."
            body = json.dumps(error_body("bad_request", message)).encode()
            headers = [
                ("content-type", "application/json"),
                ("content-length", str(len(body))),
                ("connection", "close"),
            ]
            for part in (h11.Response(status_code=400, headers=headers, reason=b"Bad Request"), h11.Data(data=body)):
                self.transport.write(self.conn.send(part) or b"")
        self.transport.close()

    # ------------------------------------------------------------------------------------------------------ inside

    def _update_deadline(self) -> None:
        """Start the deadline of the client's next step."""
        phase = self._expected_phase()
        if phase == "head":
            self._limits.waiting.setdefault(self)
        else:
            self._limits.waiting.pop(self, None)
        if phase == self._phase and self._deadline is not None:
            return
        self._cancel_deadline()
        if phase is not None:
            self._phase = phase
            seconds = BODY_IDLE_TIMEOUT_S if phase == "body" else self._limits.head
            self._deadline = self.loop.call_later(seconds, self._expire)

    def _expected_phase(self) -> _Phase | None:
        if self._upgraded or self.transport.is_closing() or self.timeout_keep_alive_task is not None:
            return None
        state = self.conn.their_state
        if state is h11.IDLE:
            return "head"
        if state is not h11.SEND_BODY:
            return None
        # The response may be complete before the body, for example if a credential is missing.
        return "body" if self.cycle is not None and not self.cycle.response_complete else "rest"

    def _expire(self) -> None:
        self._deadline = None
        if self._phase == "body" and self.flow.read_paused:
            self._update_deadline()  # we are not reading, so the client is not late
        elif not self.transport.is_closing():
            self.transport.abort()

    def _cancel_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
        self._deadline, self._phase = None, None


class _StrictBuffer(ReceiveBuffer):
    """Received bytes; heads, trailers and sizes of chunks are parsed strictly."""

    def maybe_extract_lines(self) -> list[bytearray] | None:
        if self._data[:2] != b"\r\n":  # otherwise there are no trailers, and the next request follows
            self._check_lines()
        lines = super().maybe_extract_lines()
        if lines is not None:
            _check_framing(lines)
        return lines

    def _check_lines(self) -> None:
        found = _HEAD_ENDS.search(self._data)
        head = self._data if found is None else self._data[: found.end()]
        if _BARE_LF.search(head) or _FOLDED.search(head):
            raise h11.LocalProtocolError("a line does not end with CRLF, or continues on the next line")

    def maybe_extract_next_line(self) -> bytearray | None:
        line = super().maybe_extract_next_line()
        if line is not None and not _CHUNK.fullmatch(line):
            raise h11.LocalProtocolError("the size of a chunk is not a hexadecimal number")
        return line


def _check_framing(lines: list[bytearray]) -> None:
    """Refuse a head that states the length of its body in two ways."""
    lengths = [line for line in lines if line[:15].lower() == b"content-length:"]
    coded = any(line[:18].lower() == b"transfer-encoding:" for line in lines)
    if len(lengths) > 1 or any(b"," in line for line in lengths) or (lengths and coded):
        raise h11.LocalProtocolError("the length of the body is given twice")
    if coded and lines[0].endswith(b"HTTP/1.0"):
        raise h11.LocalProtocolError("HTTP/1.0 has no Transfer-Encoding")
