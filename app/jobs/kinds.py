"""Describes a kind of job to the queue; :mod:`app.jobs.tasks` adds the work. ``app.job_kinds`` lists all kinds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from sqlalchemy.orm import Session

from app.events import EventBus
from app.jobs.lanes import Lane
from app.storage.models import Job


class OnJobFailed(Protocol):
    """Updates the subject of a failed job, and notifies the pages; in the caller's transaction."""

    def __call__(self, session: Session, events: EventBus, job: Job, state: str, error: str | None) -> None:
        """Update the subject.

        Args:
            session: writes.
            events: notifies pages.
            job: the job that failed, was cancelled or was queued again.
            state: ``failed``, ``cancelled`` or ``queued``.
            error: one sentence; None: no error.
        """


class OnJobNote(Protocol):
    """Puts the note of a job on its subject, and notifies the pages; in the caller's transaction."""

    def __call__(self, session: Session, events: EventBus, job: Job, note: str) -> None:
        """Update the subject.

        Args:
            session: writes.
            events: notifies pages.
            job: waits or runs.
            note: a few words for a progress line; empty: nothing to say.
        """


def _clear_nothing(_home: Path, _subject: str) -> None:
    """Keep unfinished work for the next attempt, or have none."""


@dataclass(frozen=True, slots=True)
class JobKind:
    """What the queue and the supervisor know of one kind of job.

    Attributes:
        name: name with which jobs are submitted.
        lane: lane whose workers do it.
        on_failed: updates the subject of a job that fails, is cancelled or is queued again.
        clear: (data folder, subject) removes the files of a job that ended without success.
        on_note: puts a note on the subject of a waiting or running job; None: its subjects have no notes.
        by_frame: a job's position is a frame of a video, so that messages can name the frame at which it died.
    """

    name: str
    lane: Lane
    on_failed: OnJobFailed
    clear: Callable[[Path, str], None] = _clear_nothing
    on_note: OnJobNote | None = None
    by_frame: bool = False


Kind_co = TypeVar("Kind_co", bound=JobKind, covariant=True)


class JobKinds(Generic[Kind_co]):
    """All kinds of jobs; those that people wait for most often come first.

    Args:
        kinds: each name once.
        worker: module that does such jobs in a process: ``python -m WORKER PARENT LANE``.

    Raises:
        ValueError: two kinds have one name.
    """

    def __init__(self, kinds: Iterable[Kind_co], worker: str) -> None:
        listed = tuple(kinds)
        self._kinds = {kind.name: kind for kind in listed}
        self.worker = worker
        if len(self._kinds) < len(listed):
            raise ValueError(f"Kinds of jobs must have different names. Got {[kind.name for kind in listed]}.")

    def __iter__(self) -> Iterator[Kind_co]:
        return iter(self._kinds.values())

    def get(self, name: str) -> Kind_co | None:
        """Return the kind with that name; None: a newer version has submitted it."""
        return self._kinds.get(name)

    def outside_lane(self, lane: Lane) -> list[str]:
        """Names of the kinds outside of a lane."""
        return [kind.name for kind in self if kind.lane != lane]

    def in_lane(self, lane: Lane) -> list[str]:
        """Names of the kinds in a lane; unknown kinds count as long."""
        return [kind.name for kind in self if kind.lane == lane]

    def lane_of(self, name: str) -> Lane:
        """The lane of a kind."""
        kind = self.get(name)
        return "long" if kind is None else kind.lane
