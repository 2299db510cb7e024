"""Tells whether Numba compiles kernels, as the first run after an installation does.

Numba announces a compilation only if its cache lacks the kernel. The time of the announcement is kept in memory that is
shared with processes that are forked later, so their compilations count as well.
"""

from __future__ import annotations

import mmap
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Final

from numba.core.event import Event, Listener, install_listener

from tsr_engine.periodic import call_periodically

COMPILING: Final = "compiling the numeric kernels, once, which takes a minute or two"
"""What a progress line says meanwhile."""
MAX_SILENCE_S: Final = 20.0
"""Seconds without a word of a process that compiles after which it has died."""
WORD_INTERVAL_S: Final = 1.0
"""Seconds between two words of a process that compiles."""
NEXT_KERNEL_S: Final = 2.0
"""Seconds after a compilation in which the next one may begin: a kernel is compiled when it is first called."""


class _Watch(Listener):  # type: ignore[misc] # numba has no types
    """Keeps the time until which kernels are being compiled.

    A thread moves that time on while a compilation lasts, however long that is, and dies with its process.
    """

    def __init__(self) -> None:
        self._until = mmap.mmap(-1, struct.calcsize("d"))  # shared with forked processes
        self._depth = 0
        self._moving_on = ExitStack()

    def on_start(self, _event: Event) -> None:
        """A kernel is compiled, perhaps for one that calls it."""
        self._depth += 1
        if self._depth == 1:
            self._compiles()
            self._moving_on.enter_context(call_periodically("compiling", WORD_INTERVAL_S, self._compiles))

    def on_end(self, _event: Event) -> None:
        """A kernel is compiled or has failed to."""
        self._depth -= 1
        if self._depth == 0:
            self._moving_on.close()
            self._set(NEXT_KERNEL_S)

    def _compiles(self) -> None:
        self._set(MAX_SILENCE_S)

    def _set(self, seconds: float) -> None:
        struct.pack_into("d", self._until, 0, time.monotonic() + seconds)

    def __call__(self) -> str:
        """What a progress line says: ``COMPILING``, or nothing."""
        until: float = struct.unpack_from("d", self._until)[0]
        return COMPILING if time.monotonic() < until else ""


@contextmanager
def watch_compilation() -> Iterator[Callable[[], str]]:
    """Watch Numba during a block.

    Yields:
        A function that returns what a progress line says: ``COMPILING`` while kernels are being compiled, by this
        process or by one that it has forked in the block, else an empty text.
    """
    watch = _Watch()
    with install_listener("numba:compile", watch):
        yield watch


@contextmanager
def report_compilation(report: Callable[[str], bool], every: float) -> Iterator[None]:
    """Report from a thread, during a block, when a compilation begins and when it is over.

    Args:
        report: called with ``COMPILING`` or an empty text; False: it failed and is called again.
        every: seconds between two looks.
    """
    reported = ""
    with watch_compilation() as note_now:

        def report_change() -> None:
            nonlocal reported
            if (note := note_now()) != reported and report(note):
                reported = note

        with call_periodically("compilation", every, report_change):
            yield
