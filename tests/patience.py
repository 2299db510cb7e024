"""How long a test waits for what should take no time.

Goals hold on a quiet machine; one that also does other work gets ``TSR_TIMES`` times as long, 8 unless said otherwise.
``TSR_TIMES=1`` on a quiet machine holds the goals themselves.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

__all__ = ["TIMES", "until", "within"]

TIMES = float(os.environ.get("TSR_TIMES", "8"))
"""How many times its goal a wait may take."""


def within(seconds: float) -> float:
    """A goal in seconds as this machine has to meet it."""
    return seconds * TIMES


def until(what: Callable[[], Any], seconds: float = 240.0) -> Any:
    """Until something is so; its value."""
    end, pause = time.monotonic() + seconds, 0.01
    while not (found := what()):
        assert time.monotonic() < end, "it does not happen"
        time.sleep(pause)
        pause = min(1.2 * pause, 0.05)  # asking takes time from what is waited for
    return found
