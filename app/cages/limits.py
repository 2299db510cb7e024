"""Limits of a process that reads bytes from outside."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

__all__ = ["NICE", "Limits", "stored_in"]

NICE: Final = 5
"""For imports: behind the server, which answers others meanwhile, and before the workers."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What a cage may use.

    Attributes:
        memory_mb: address space beyond what the process begins with, MiB.
        computing: processor time on all its threads together, seconds; 0: as much as it wants.
        wall: seconds from question to answer; 0: as long as it takes.
        writable: folders that it may write below; empty: it writes no file at all.
        file_mb: largest file that it writes, MiB.
        nice: how far it stands back for the server and for what people wait for, as of ``nice``.
        network: may open connections, and writes wherever it may: it stores in a database that is elsewhere.
    """

    memory_mb: int
    computing: int = 0
    wall: float = 0.0
    writable: tuple[Path, ...] = ()
    file_mb: int = 1 << 15
    nice: int = 0
    network: bool = False


def stored_in(home: Path, database: Path) -> tuple[Path, ...]:
    """Folders that a process writes below which stores something.

    Args:
        home: the data folder; parts of it may be links to other disks.
        database: the file of the SQLite database.
    """
    parts = (part.resolve() for part in home.iterdir() if part.is_symlink())
    return (home, database.parent, Path(tempfile.gettempdir()), *(part for part in parts if part.is_dir()))
