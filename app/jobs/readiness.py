"""What a worker of the short lane loads while it has nothing to do, so that the next job begins at once.

A what-if of a process that has just begun spends three seconds on loading the engine, a recording one on the Rerun SDK.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from app.jobs.lanes import SHORT_KINDS
from app.jobs.tasks import task_of

__all__ = ["STAY", "preparations"]

STAY: Final = "stay"
"""Third argument of a worker that does not end when it is idle."""


def preparations() -> Iterator[Callable[[], object]]:
    """Steps of a second at most, those for what people wait for most often first; jobs may come between two of them."""
    yield partial(task_of, "recording")
    yield _recorder
    yield _sdk
    yield partial(task_of, "whatif")
    yield _replay
    for kind in SHORT_KINDS:
        yield partial(task_of, kind)


def _recorder() -> None:
    import tsr_engine.recording  # noqa: F401


def _sdk() -> None:
    from tsr_engine.recording.sink import load_sdk

    load_sdk()


def _replay() -> None:
    import tsr_engine.replay  # noqa: F401
