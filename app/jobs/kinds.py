"""Describes a kind of job to the queue. ``app.kinds`` has all kinds; the queue imports none of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.lanes import Lane
from app.storage.models import Job
from tsr_engine.json_shapes import JsonObject

if TYPE_CHECKING:
    from app.jobs.context import TaskContext
    from app.settings import Settings
    from app.storage.database import Database

__all__ = ["JobKind", "JobKinds", "OnJobFailed", "Task"]

Task = Callable[["TaskContext"], None]
"""Does one job in a worker; a ``TsrError`` of it is the sentence that people get."""


class OnJobFailed(Protocol):
    """Updates the subject of a failed job, and notifies the pages; in the caller's transaction."""

    def __call__(self, session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
        """Settle it.

        Args:
            session: writes.
            events: where pages hear of it.
            job: that did not end well, or waits again.
            state: ``failed``, ``cancelled`` or ``queued``.
            error: one sentence; None: nothing is wrong.
        """


def _nothing(_home: Path, _subject: str) -> None:
    """Of unfinished work there is nothing to remove, or it stays for the next attempt."""


@dataclass(frozen=True, slots=True)
class JobKind:
    """One kind of job.

    Attributes:
        name: as jobs of it are submitted.
        lane: whose workers do it.
        load: imports the function that does it: the engine is large, and the server does not need it.
        on_failed: what becomes of the subject of a job that does not end well.
        clear: data folder, subject: removes what a job that is over without an end has left.
        prepare: steps of a second at most that a worker does in advance, after ``load``.
        expect: gets ready for a job that a person may be about to ask for: settings, database, what is known of it.
        by_frame: a job's position is a frame of a video, so that people can be informed where it died.
    """

    name: str
    lane: Lane
    load: Callable[[], Task]
    on_failed: OnJobFailed
    clear: Callable[[Path, str], None] = _nothing
    prepare: tuple[Callable[[], object], ...] = ()
    expect: Callable[[Settings, Database, JsonObject], None] | None = None
    by_frame: bool = False


class JobKinds:
    """All kinds of jobs; those that people wait for most often come first.

    Args:
        kinds: each name once.
        worker: module that a process runs to do such jobs: ``python -m WORKER PARENT LANE``.

    Raises:
        ValueError: two kinds have one name.
    """

    def __init__(self, kinds: Iterable[JobKind], worker: str) -> None:
        given = tuple(kinds)
        self._kinds = {kind.name: kind for kind in given}
        self.worker = worker
        if len(self._kinds) < len(given):
            raise ValueError(f"Each kind of job has a name of its own. Got {[kind.name for kind in given]}.")

    def __iter__(self) -> Iterator[JobKind]:
        return iter(self._kinds.values())

    def get(self, name: str) -> JobKind | None:
        """The kind of that name; None: a newer version has submitted it."""
        return self._kinds.get(name)

    def beside(self, lane: Lane) -> list[str]:
        """Names of those that are not in a lane."""
        return [kind.name for kind in self if kind.lane != lane]

    def within(self, lane: Lane) -> list[str]:
        """Names of those in a lane; unknown ones are long."""
        return [kind.name for kind in self if kind.lane == lane]

    def lane(self, name: str) -> Lane:
        """The lane of a kind."""
        kind = self.get(name)
        return "long" if kind is None else kind.lane

    def task(self, name: str) -> Task:
        """The function that does jobs of a kind.

        Raises:
            KeyError: there is no such kind.
        """
        return self._kinds[name].load()
