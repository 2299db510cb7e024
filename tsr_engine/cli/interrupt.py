"""Turns Ctrl-C into a flag that long work checks between two frames, so that no output is torn."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

import typer

from tsr_engine.cli.common import say

EXIT_INTERRUPTED = 130


def leave_interrupted(kept: str) -> NoReturn:
    """End a command after Ctrl-C, with the sentence ``kept`` on what is kept.

    Raises:
        typer.Exit: with the exit code of an interruption.
    """
    say(f"Interrupted. {kept}")
    raise typer.Exit(EXIT_INTERRUPTED)


@contextmanager
def stop_on_interrupt() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C (or SIGTERM) has come; a second Ctrl-C interrupts at once."""
    stop_requested = threading.Event()

    def handler(number: int, frame: FrameType | None) -> None:
        if stop_requested.is_set() and number == signal.SIGINT:
            raise KeyboardInterrupt
        stop_requested.set()

    old_handlers = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop_requested.is_set
    finally:
        for number, old_handler in old_handlers.items():
            signal.signal(number, old_handler)
