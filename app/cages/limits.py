"""What one process that reads bytes from outside may use."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

__all__ = ["Limits"]


@dataclass(frozen=True, slots=True)
class Limits:
    """What a cage may use.

    Attributes:
        memory_mb: address space beyond what the process begins with, MiB.
        computing: processor time on all its threads together, seconds; 0: as much as it wants.
        wall: seconds from question to answer; 0: as long as it takes.
        writable: folders that it may write below; empty: it writes no file at all.
        file_mb: largest file that it writes, MiB.
        network: may open connections. A cage that stores what another one has read reaches the database by that.
    """

    memory_mb: int
    computing: int = 0
    wall: float = 0.0
    writable: tuple[Path, ...] = ()
    file_mb: int = 1 << 15
    network: bool = False
