"""Deadlines of tests.

Goals hold on an idle machine; on a busy one they are multiplied by ``TSR_TIMES``, 8 by default. ``TSR_TIMES=1`` on an
idle machine tests the goals themselves.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

__all__ = ["TIME_FACTOR", "time_limit", "wait_until"]

TIME_FACTOR = float(os.environ.get("TSR_TIMES", "8"))
"""How many times its goal a wait may take."""


def time_limit(seconds: float) -> float:
    """A goal in seconds, scaled for this machine."""
    return seconds * TIME_FACTOR


def wait_until(condition: Callable[[], Any], seconds: float = 240.0) -> Any:
    """Wait until a value is true; returns it."""
    deadline, pause = time.monotonic() + seconds, 0.01
    while not (found := condition()):
        assert time.monotonic() < deadline, "it does not happen"
        time.sleep(pause)
        pause = min(1.2 * pause, 0.05)  # asking takes time from what is waited for
    return found
