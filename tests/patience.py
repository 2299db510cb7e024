"""How long a test waits for what should take no time.

Goals hold on a quiet machine; one that also does other work gets ``TSR_TIMES`` times as long, 8 unless said otherwise.
``TSR_TIMES=1`` on a quiet machine holds the goals themselves.
"""

from __future__ import annotations

import os

__all__ = ["within"]

TIMES = float(os.environ.get("TSR_TIMES", "8"))


def within(seconds: float) -> float:
    """A goal in seconds as this machine has to meet it."""
    return seconds * TIMES
