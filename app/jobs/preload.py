"""Modules that an idle worker of the short lane loads in advance, so that the next job starts at once.

In a new process a what-if would spend three seconds on loading the engine, a recording one second on the Rerun SDK.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

from app.jobs.kinds import JobKinds
from app.jobs.tasks import TaskKind

STANDBY: Final = "stay"
"""Third argument of a worker that does not end when it is idle."""


def preparations(kinds: JobKinds[TaskKind]) -> Iterator[Callable[[], object]]:
    """Steps of at most a second, the most often awaited first; jobs may come between two of them."""
    for kind in kinds:
        if kind.lane == "short":
            yield kind.load
            yield from kind.prepare
