"""Running imports: their progress for the page that waits, and a way to stop them."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

from app.errors import Conflict, NotFound
from app.shapes import Model

__all__ = ["Import", "ImportProgress", "ImportsUnderway", "Step"]

Step = Literal["waiting", "reading", "storing"]


class ImportProgress(Model):
    """Progress of an import."""

    step: Step
    boxes: int
    """Number of boxes read so far."""
    seconds: float
    """Seconds since its file was received."""


@dataclass(slots=True)
class Import:
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


class ImportsUnderway:
    """The running imports of one server to which pages have given a name; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._named: dict[str, Import] = {}

    @contextmanager
    def begun(self, name: str | None) -> Iterator[Import]:
        """Register an import until the block ends.

        Args:
            name: chosen by the page; None: its progress will not be requested.

        Raises:
            Conflict: another import has that name.
        """
        made = Import()
        if name is None:
            yield made
            return
        with self._lock:
            if self._named.setdefault(name, made) is not made:
                raise Conflict("An import of that name is underway. Choose another name.", field="progress")
        try:
            yield made
        finally:
            with self._lock:
                del self._named[name]

    def progress(self, name: str) -> ImportProgress:
        """Return the progress of an import.

        Raises:
            NotFound: it has ended, or no import has that name.
        """
        found = self._of(name)
        return ImportProgress(step=found.step, boxes=found.boxes, seconds=round(time.monotonic() - found.began, 1))

    def cancel(self, name: str) -> None:
        """Cancel an import unless it is being stored; its own request returns the result.

        Raises:
            NotFound: as for ``progress``.
            Conflict: it is being stored.
        """
        found = self._of(name)
        found.cancelled.set()
        if found.step == "storing":
            raise Conflict("The import is being stored already.")

    def _of(self, name: str) -> Import:
        with self._lock:
            found = self._named.get(name)
        if found is None:
            raise NotFound("There is no such import underway.")
        return found
