"""Running imports: their progress for the page that waits, and a way to stop them."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

from app.body_model import Model
from app.errors import Conflict, NotFound

Step = Literal["waiting", "reading", "storing"]


class ImportProgress(Model):
    """Progress of an import."""

    step: Step
    boxes: int
    """Number of boxes read so far."""
    seconds: float
    """Seconds since its file was received."""


@dataclass(slots=True)
class RunningImport:
    """One running import.

    Attributes:
        step: current step.
        boxes: number of boxes read so far.
        cancelled: set when it is cancelled.
    """

    step: Step = "waiting"
    boxes: int = 0
    cancelled: threading.Event = field(default_factory=threading.Event)
    began: float = field(default_factory=time.monotonic)


class RunningImports:
    """The running imports of one server to which pages have given a name; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._imports: dict[str, RunningImport] = {}

    @contextmanager
    def register(self, name: str | None) -> Iterator[RunningImport]:
        """Register an import until the block ends.

        Args:
            name: chosen by the page; None: its progress will not be requested.

        Raises:
            Conflict: another import has that name.
        """
        entry = RunningImport()
        if name is None:
            yield entry
            return
        with self._lock:
            if self._imports.setdefault(name, entry) is not entry:
                raise Conflict("An import of that name is underway. Choose another name.", field="progress")
        try:
            yield entry
        finally:
            with self._lock:
                del self._imports[name]

    def progress(self, name: str) -> ImportProgress:
        """Return the progress of an import.

        Raises:
            NotFound: it has ended, or no import has that name.
        """
        entry = self._require(name)
        return ImportProgress(step=entry.step, boxes=entry.boxes, seconds=round(time.monotonic() - entry.began, 1))

    def cancel(self, name: str) -> None:
        """Cancel an import unless it is being stored; its own request returns the result.

        Raises:
            NotFound: as for ``progress``.
            Conflict: it is being stored.
        """
        entry = self._require(name)
        entry.cancelled.set()
        if entry.step == "storing":
            raise Conflict("The import is being stored already.")

    def _require(self, name: str) -> RunningImport:
        with self._lock:
            entry = self._imports.get(name)
        if entry is None:
            raise NotFound("There is no such import underway.")
        return entry
