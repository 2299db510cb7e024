"""Shows the progress of long work on stderr, with rate and time left, if it is a terminal.

Elsewhere it only says that kernels are compiled, because the first run then takes a minute longer.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from tsr_engine.cli.common import say

ShowProgress = Callable[[int, int | None, str], None]
_POLL_INTERVAL_S: Final = 0.5
"""Seconds between two looks at the compiler."""


class CompilationNote:
    """Says once on stderr that kernels are being compiled; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._printed = False

    def __call__(self, note: str) -> bool:
        """Take a note, or an empty text when it is over; returns True, because no call has to be repeated."""
        with self._lock:
            if note and not self._printed:
                self._printed = True
                say(f"{note.capitalize()}.")
        return True


@contextmanager
def progress_bar(title: str, unit: str) -> Iterator[ShowProgress]:
    """A progress bar on stderr if that is a terminal, else one line there if kernels are compiled.

    Yields:
        A function to call with the number done, the total if known, and the rate as text.
    """
    from tsr_engine.compilation import report_compilation, watch_compilation

    if not sys.stderr.isatty():
        with report_compilation(CompilationNote(), _POLL_INTERVAL_S):
            yield lambda done, total, rate: None
        return
    from rich.console import Console, RenderableType
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
    from rich.text import Text

    columns = (
        TextColumn("{task.description}", markup=False),  # it may hold a file's name
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(unit + " {task.fields[rate]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )

    class Bar(Progress):
        """Says below the bar that kernels are being compiled."""

        def get_renderables(self) -> Iterator[RenderableType]:
            yield self.make_tasks_table(self.tasks)
            if note := current_note():
                yield Text(f"{note} ...")

    with (
        watch_compilation() as current_note,
        Bar(*columns, console=Console(stderr=True), transient=True, refresh_per_second=5) as bar,
    ):
        task = bar.add_task(title, total=None, rate="")
        yield lambda done, total, rate: bar.update(task, completed=done, total=total, rate=rate)


def rate_text(rate: float | None) -> str:
    """The rate beside the bar: frames per second; empty during the first frame."""
    return "" if rate is None else f"{rate:.1f}/s"
