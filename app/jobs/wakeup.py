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

ExpectedJob = tuple[str, JsonObject]
"""Kind of an expected job, and its known data."""
_MAX_BYTES: Final = 65536


class WakeupSender:
    """The server's end of the pipe; thread-safe.

    Attributes:
        receiver: file descriptor of the worker's end.
    """

    def __init__(self) -> None:
        self.receiver, self._sender = os.pipe()
        os.set_blocking(self._sender, False)  # never wait for a busy worker

    def send(self, expected: ExpectedJob | None = None) -> None:
        """Announce a new job, or an expected one; a worker that has not read for long misses it."""
        line = "" if expected is None else json.dumps(expected)
        with suppress(OSError):
            os.write(self._sender, f"{line}\n".encode())

    def close(self) -> None:
        """Close the pipe."""
        os.close(self.receiver)
        os.close(self._sender)


class WakeupListener:
    """The worker's end of the pipe: its standard input, or another file descriptor."""

    def __init__(self, file: int = 0) -> None:
        self._file = file
        self._open = True

    def wait(self, seconds: float) -> ExpectedJob | None:
        """Sleep until a notification arrives or the time is up; return the newest expected job, if any."""
        if not self._open:
            time.sleep(seconds)
            return None
        if not select.select([self._file], [], [], seconds)[0]:
            return None
        data = os.read(self._file, _MAX_BYTES)
        self._open = bool(data)  # the server has ended; the signal for it is on its way
        lines = [line for line in data.splitlines() if line]
        if not lines:
            return None
        kind, known = json.loads(lines[-1])
        return kind, known
