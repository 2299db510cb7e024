"""Notifies the standby worker at once of a new job, or of a job that a person may request soon.

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
"""Kind of an expected job, and its known data."""
_MOST: Final = 65536


class Bell:
    """The server's end of the pipe; thread-safe.

    Attributes:
        heard: file descriptor of the worker's end.
    """

    def __init__(self) -> None:
        self.heard, self._rung = os.pipe()
        os.set_blocking(self._rung, False)  # never wait for a busy worker

    def ring(self, expected: Expected | None = None) -> None:
        """Announce a new job, or an expected one; a worker that has not read for long misses it."""
        line = "" if expected is None else json.dumps(expected)
        with suppress(OSError):
            os.write(self._rung, f"{line}\n".encode())

    def close(self) -> None:
        """Close the pipe."""
        os.close(self.heard)
        os.close(self._rung)


class Listener:
    """The worker's end of the pipe: its standard input, or another file descriptor."""

    def __init__(self, file: int = 0) -> None:
        self._file = file
        self._open = True

    def wait(self, seconds: float) -> Expected | None:
        """Sleep until a notification arrives or the time is up; return the newest expected job, if any."""
        if not self._open:
            time.sleep(seconds)
            return None
        if not select.select([self._file], [], [], seconds)[0]:
            return None
        heard = os.read(self._file, _MOST)
        self._open = bool(heard)  # the server has ended; the signal for it is on its way
        lines = [line for line in heard.splitlines() if line]
        if not lines:
            return None
        kind, about = json.loads(lines[-1])
        return kind, about
