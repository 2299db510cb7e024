"""Notifies the standby worker at once of a new job, or of a job that a person may be about to ask for.

The notification is a line through a pipe: empty for a new job, else a kind of job to prepare for.
"""

from __future__ import annotations

import json
import os
import select
import time
from contextlib import suppress
from typing import Final

from tsr_engine.json_shapes import JsonObject

__all__ = ["Bell", "Expected", "Listener"]

Expected = tuple[str, JsonObject]
"""Kind of a job, and what is known of it."""
_MOST: Final = 65536


class Bell:
    """The server's end; safe to use from any thread.

    Attributes:
        heard: file number of the worker's end.
    """

    def __init__(self) -> None:
        self.heard, self._rung = os.pipe()
        os.set_blocking(self._rung, False)  # nobody waits for a worker that has other things to do

    def ring(self, expected: Expected | None = None) -> None:
        """There is a new job, or soon may be one; a worker that has not listened for long misses it."""
        line = "" if expected is None else json.dumps(expected)
        with suppress(OSError):
            os.write(self._rung, f"{line}\n".encode())

    def close(self) -> None:
        """Release the pipe."""
        os.close(self.heard)
        os.close(self._rung)


class Listener:
    """The worker's end: its standard input, or another file by its number."""

    def __init__(self, file: int = 0) -> None:
        self._file = file
        self._open = True

    def wait(self, seconds: float) -> Expected | None:
        """Sleep, until there is a call at most; the newest job that is expected, if any is."""
        if not self._open:
            time.sleep(seconds)
            return None
        if not select.select([self._file], [], [], seconds)[0]:
            return None
        heard = os.read(self._file, _MOST)
        self._open = bool(heard)  # the server is gone; the signal of its end is on the way
        lines = [line for line in heard.splitlines() if line]
        if not lines:
            return None
        kind, about = json.loads(lines[-1])
        return kind, about
