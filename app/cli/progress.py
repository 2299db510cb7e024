"""Progress of a command's steps, which Ctrl-C stops between two of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tsr_engine.cli.interrupt import stop_on_interrupt
from tsr_engine.cli.progress import progress_bar


@contextmanager
def step_counter(title: str) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar; yields a function to call with the number of steps done and their total.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed before a call of that function.
    """
    with progress_bar(title, "steps") as show, stop_on_interrupt() as stopped:

        def step(done: int, of: int) -> None:
            if stopped():
                raise KeyboardInterrupt
            show(done, of, "")

        yield step
