"""Messages between the server and a sandbox: JSON and bytes, never pickle."""

from __future__ import annotations

import json
import socket
import struct
from typing import Final

from tsr_engine.json_shapes import JsonObject

_HEADER: Final = struct.Struct(">IQ")
_MAX_TEXT_BYTES: Final = 64 << 20


class ChannelClosed(Exception):
    """The other side has closed the connection, or sent an invalid message."""


class Channel:
    """One end of the connection between server and sandbox; for one thread at a time.

    Args:
        connection: a connected stream socket, closed with this.
        max_content: maximum size of a message without its text, bytes.
    """

    def __init__(self, connection: socket.socket, max_content: int = 1 << 30) -> None:
        self._connection = connection
        self._max_content = max_content

    def fileno(self) -> int:
        """The file descriptor, for ``select`` and the like."""
        return self._connection.fileno()

    def set_timeout(self, seconds: float) -> None:
        """Set the seconds to wait for each piece of a message; then the connection counts as ended."""
        self._connection.settimeout(seconds)

    def send(self, text: JsonObject, content: bytes | memoryview = b"") -> None:
        """Send a message.

        Raises:
            ChannelClosed: the other side has closed the connection.
        """
        encoded = json.dumps(text).encode()
        try:
            self._connection.sendall(_HEADER.pack(len(encoded), len(content)) + encoded)
            if len(content):
                self._connection.sendall(content)
        except OSError:
            raise ChannelClosed from None

    def receive(self) -> tuple[JsonObject, bytearray]:
        """Receive the next message.

        Raises:
            ChannelClosed: the connection has ended, or the message is invalid.
        """
        text_size, content_size = _HEADER.unpack(self._read(_HEADER.size))
        if text_size > _MAX_TEXT_BYTES or content_size > self._max_content:
            raise ChannelClosed
        try:
            text = json.loads(self._read(text_size))
        except ValueError:
            raise ChannelClosed from None
        if not isinstance(text, dict):
            raise ChannelClosed
        return text, self._read(content_size)

    def close(self) -> None:
        """Close this end."""
        self._connection.close()

    def _read(self, count: int) -> bytearray:
        data = bytearray(count)
        remaining = memoryview(data)
        while len(remaining):
            try:
                received = self._connection.recv_into(remaining, min(len(remaining), 1 << 20))
            except OSError:
                raise ChannelClosed from None
            if not received:
                raise ChannelClosed
            remaining = remaining[received:]
        return data
