"""How many cores this process may use."""

from __future__ import annotations

import os
from typing import Any

__all__ = ["usable_cores"]


def usable_cores() -> int:
    """Cores that this process may use; less than the machine has where it was confined to some of them."""
    affinity: Any = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
