"""A TCP proxy of a PostgreSQL cluster that can drop all packets, as a broken network does."""

from __future__ import annotations

import ctypes
import socket
import struct
import threading
from contextlib import suppress
from types import TracebackType
from typing import Final

_ATTACH: Final = 26
_DETACH: Final = 27
_DROP_ALL: Final = ctypes.create_string_buffer(struct.pack("HBBI", 0x06, 0, 0, 0))
"""A filter of Linux for packets (BPF) that returns 0: keep no byte."""


class DroppingProxy:
    """Forwards connections from a TCP port to a socket file; a context manager.

    While packets are dropped, neither side gets an answer: no reset, and no acknowledgement.

    Args:
        target: path of the socket file.

    Attributes:
        port: the TCP port, on 127.0.0.1.
    """

    def __init__(self, target: str) -> None:
        self._target = target
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        self._client_side: list[socket.socket] = [self._listener]
        self._upstream: list[socket.socket] = []
        self._is_open = threading.Event()
        self._is_open.set()

    def __enter__(self) -> DroppingProxy:
        threading.Thread(target=self._accept, daemon=True).start()
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._is_open.set()
        for opened in (*self._client_side, *self._upstream):
            with suppress(OSError):
                opened.shutdown(socket.SHUT_RDWR)
            opened.close()

    def drop(self) -> None:
        """Drop all packets from now on."""
        self._is_open.clear()
        program = struct.pack("HL", 1, ctypes.addressof(_DROP_ALL))
        for opened in self._client_side:
            opened.setsockopt(socket.SOL_SOCKET, _ATTACH, program)

    def restore(self) -> None:
        """Let packets through again."""
        for opened in self._client_side:
            with suppress(OSError):
                opened.setsockopt(socket.SOL_SOCKET, _DETACH, 0)
        self._is_open.set()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                self._client_side.append(client)
                upstream = socket.socket(socket.AF_UNIX)
                self._upstream.append(upstream)
                upstream.connect(self._target)
                for source, sink in ((client, upstream), (upstream, client)):
                    threading.Thread(target=self._pump, args=(source, sink), daemon=True).start()

    def _pump(self, source: socket.socket, sink: socket.socket) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                self._is_open.wait()
                sink.sendall(data)
            sink.shutdown(socket.SHUT_WR)
