"""Progress of long work on stderr: rate and time left, only where a person looks at a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["progress_bar", "rate_text"]

Show = Callable[[int, int | None, str], None]


@contextmanager
def progress_bar(title: str, unit: str) -> Iterator[Show]:
    """A bar on stderr if that is a terminal.

    Args:
        title: what is going on.
        unit: what is counted.

    Yields:
        A function to call with the number done, the total if known, and a rate as text.
    """
    if not sys.stderr.isatty():
        yield lambda done, total, rate: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(unit + " {task.fields[rate]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True, refresh_per_second=5) as bar:
        task = bar.add_task(title, total=None, rate="")
        yield lambda done, total, rate: bar.update(task, completed=done, total=total, rate=rate)


def rate_text(rate: float | None) -> str:
    """What stands beside the bar: frames a second; nothing while only the first frame is done."""
    return "" if rate is None else f"{rate:.1f}/s"
