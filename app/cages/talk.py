"""Messages between the server and a cage: JSON and bytes, never pickle."""

from __future__ import annotations

import json
import socket
import struct
from typing import Final

from tsr_engine.json_shapes import JsonObject

__all__ = ["Ended", "Talk"]

_LENGTHS: Final = struct.Struct(">IQ")
_MOST_TEXT: Final = 64 << 20


class Ended(Exception):
    """The other side has closed the connection, or sent an invalid message."""


class Talk:
    """One end of the connection between server and cage; for one thread at a time.

    Args:
        end: a connected stream socket, closed with this.
        most: maximum size of a message without its text, bytes.
    """

    def __init__(self, end: socket.socket, most: int = 1 << 30) -> None:
        self._end = end
        self._most = most

    def fileno(self) -> int:
        """The file descriptor, for ``select`` and the like."""
        return self._end.fileno()

    def set_timeout(self, seconds: float) -> None:
        """Set the seconds to wait for each piece of a message; then the connection counts as ended."""
        self._end.settimeout(seconds)

    def send(self, text: JsonObject, content: bytes | memoryview = b"") -> None:
        """Send a message.

        Raises:
            Ended: the other side has closed the connection.
        """
        encoded = json.dumps(text).encode()
        try:
            self._end.sendall(_LENGTHS.pack(len(encoded), len(content)) + encoded)
            if len(content):
                self._end.sendall(content)
        except OSError:
            raise Ended from None

    def receive(self) -> tuple[JsonObject, bytearray]:
        """Receive the next message.

        Raises:
            Ended: the connection has ended, or the message is invalid.
        """
        text, content = _LENGTHS.unpack(self._take(_LENGTHS.size))
        if text > _MOST_TEXT or content > self._most:
            raise Ended
        try:
            found = json.loads(self._take(text))
        except ValueError:
            raise Ended from None
        if not isinstance(found, dict):
            raise Ended
        return found, self._take(content)

    def close(self) -> None:
        """Close this end."""
        self._end.close()

    def _take(self, count: int) -> bytearray:
        data = bytearray(count)
        rest = memoryview(data)
        while len(rest):
            try:
                got = self._end.recv_into(rest, min(len(rest), 1 << 20))
            except OSError:
                raise Ended from None
            if not got:
                raise Ended
            rest = rest[got:]
        return data
