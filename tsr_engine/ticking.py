"""Calls a function periodically in a thread during a block of work."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["ticking"]


@contextmanager
def ticking(name: str, every: float, do: Callable[[], None]) -> Iterator[None]:
    """Call a function periodically until the block ends; a call in progress is waited for.

    Args:
        name: name of the thread.
        every: pause before each call, seconds.
        do: the function; raises nothing.
    """
    over = threading.Event()

    def tick() -> None:
        while not over.wait(every):
            do()

    thread = threading.Thread(target=tick, name=name, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
