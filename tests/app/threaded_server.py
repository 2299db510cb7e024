"""A server on a real port, in a thread of this process, for tests with real connections."""

from __future__ import annotations

import asyncio
import faulthandler
import gc
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from app.cli.serve import ReviewServer, server_config
from app.security.connections import ConnectionLimits
from tests.app.toy_server import Server
from tests.waiting import time_limit


class ThreadedServer:
    """A served application."""

    def __init__(self, server: Server, limits: ConnectionLimits | None = None) -> None:
        self.server = server
        self.listener = socket.socket()
        self.listener.bind(("127.0.0.1", 0))
        self.port: int = self.listener.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self.uvicorn = ReviewServer(server_config(server.app, limits, log_level="critical", ws="none"))
        self.thread = threading.Thread(target=self.uvicorn.run, kwargs={"sockets": [self.listener]}, daemon=True)

    def start(self) -> None:
        """Start serving; returns when requests are answered."""
        self.thread.start()
        deadline = time.monotonic() + time_limit(30)
        while not self.uvicorn.started:
            assert self.thread.is_alive(), "the server has ended at once"
            assert time.monotonic() < deadline, "the server does not start"
            time.sleep(0.01)

    def stop(self) -> float:
        """Shut down as Ctrl-C does; returns the duration in seconds."""
        began = time.monotonic()
        self.uvicorn.should_exit = True
        self.thread.join(20)
        if self.thread.is_alive():
            faulthandler.dump_traceback()  # which part blocks
            print_tasks()
        assert not self.thread.is_alive(), "the server does not end"
        self.listener.close()
        return time.monotonic() - began


def print_tasks() -> None:
    """Print what the tasks of all event loops of this process wait for."""
    for loop in gc.get_objects():
        if isinstance(loop, asyncio.BaseEventLoop) and not loop.is_closed():
            print(f"loop {loop!r}: {vars(loop)!r}", file=sys.stderr)
            for task in asyncio.all_tasks(loop):
                task.print_stack(file=sys.stderr)


@contextmanager
def serve_in_thread(server: Server, limits: ConnectionLimits | None = None) -> Iterator[ThreadedServer]:
    """The application on its own port."""
    made = ThreadedServer(server, limits)
    made.start()
    try:
        yield made
    finally:
        if made.thread.is_alive():
            made.stop()
