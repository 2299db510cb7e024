"""Calls a function periodically in a thread during a block of work."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def call_periodically(name: str, pause: float, function: Callable[[], None]) -> Iterator[None]:
    """Call a function periodically until the block ends; a call in progress is waited for.

    Args:
        name: name of the thread.
        pause: pause before each call, seconds.
        function: the function; raises nothing.
    """
    stopped = threading.Event()

    def loop() -> None:
        while not stopped.wait(pause):
            function()

    thread = threading.Thread(target=loop, name=name, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stopped.set()
        thread.join()
