"""Runs an iterator in a background thread, ahead of its consumer, behind a bounded queue."""

from __future__ import annotations

import atexit
import queue
import threading
from collections.abc import Callable, Iterator
from typing import TypeVar

T = TypeVar("T")

_JOIN_TIMEOUT_S = 5.0
"""Seconds to wait for each thread at the end of the process."""
_running: dict[threading.Thread, threading.Event] = {}
"""Threads that read ahead, and the event that stops each."""


@atexit.register
def _end_all() -> None:
    """Stop threads without a consumer: a thread inside a library at the end of the process aborts it."""
    for stop in list(_running.values()):
        stop.set()
    for thread in list(_running):
        thread.join(_JOIN_TIMEOUT_S)


def read_ahead(make_iterator: Callable[[], Iterator[T]], depth: int) -> Iterator[T]:
    """Yield the items of ``make_iterator()`` in order, up to ``depth`` items ahead of the consumer.

    The iterator is created, advanced and closed in the background thread. Its exceptions, including those of
    ``make_iterator``, reach the consumer after the items before them. Leaving early (``close()``, ``break``, an error)
    stops the thread.

    Args:
        make_iterator: makes the iterator.
        depth: largest number of waiting items, >= 1.
    """
    if depth < 1:
        raise ValueError(f"The depth of reading ahead must be at least 1. Got {depth}.")
    items_queue: queue.Queue[tuple[T] | BaseException | None] = queue.Queue(maxsize=depth)
    stop = threading.Event()

    def put(item: tuple[T] | BaseException | None) -> bool:
        while not stop.is_set():
            try:
                items_queue.put(item, timeout=0.1)
            except queue.Full:
                continue
            return True
        return False

    def produce() -> None:
        items: Iterator[T] | None = None
        try:
            items = make_iterator()
            for item in items:
                if not put((item,)):
                    return
            put(None)
        except BaseException as error:
            put(error)  # raised again in the consumer's thread
        finally:
            close = getattr(items, "close", None)
            if close is not None:
                close()
            _running.pop(threading.current_thread(), None)

    thread = threading.Thread(target=produce, name="tsr-read-ahead", daemon=True)
    _running[thread] = stop
    thread.start()
    try:
        while (item := items_queue.get()) is not None:
            if isinstance(item, BaseException):
                raise item
            yield item[0]
    finally:
        stop.set()
        thread.join()
