"""Distribution of test files over processes."""

from __future__ import annotations

from contextlib import suppress

from xdist.scheduler import LoadFileScheduling
from xdist.workermanage import WorkerController

__all__ = ["FileScheduling"]


class FileScheduling(LoadFileScheduling):
    """``--dist loadfile`` that also ends after a process of tests has crashed.

    pytest-xdist 3.8 ends the whole run if it sends a file to a process before it has noticed its crash. It queues all
    files of a crashed process again, complete ones too: a process that gets a complete file as its last one waits
    forever for a test to follow.
    """

    def _assign_work_unit(self, node: WorkerController) -> None:
        """Give a process the next file; if the process is gone, ``remove_node`` queues the file again."""
        with suppress(OSError):
            super()._assign_work_unit(node)

    def remove_node(self, node: WorkerController) -> str | None:
        """Remove a process and queue its files that are not complete; returns the test that it crashed in."""
        files = self.assigned_work[node]
        self.assigned_work[node] = {name: tests for name, tests in files.items() if not all(tests.values())}
        return super().remove_node(node)
