"""Limits of a process that reads bytes from outside."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

NICE: Final = 5
"""For imports: lower priority than the server, which answers others meanwhile, and higher than the workers."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a sandbox.

    Attributes:
        memory_mb: address space beyond that at the start, MiB.
        computing: processor time of all its threads together, seconds; 0: unlimited.
        wall: time from request to answer, seconds; 0: unlimited.
        writable: folders below which it may write; empty: it writes no file.
        file_mb: largest file that it may write, MiB.
        nice: priority, as of ``nice``: higher values give way to the server and to jobs that people wait for.
        network: it may open connections and write everywhere, because it stores in a database elsewhere.
    """

    memory_mb: int
    computing: int = 0
    wall: float = 0.0
    writable: tuple[Path, ...] = ()
    file_mb: int = 1 << 15
    nice: int = 0
    network: bool = False


def writable_folders(home: Path, database: Path) -> tuple[Path, ...]:
    """Return the folders below which a process that stores results must be able to write.

    Args:
        home: the data folder; parts of it may be links to other disks.
        database: the file of the SQLite database.
    """
    parts = (part.resolve() for part in home.iterdir() if part.is_symlink())
    return (home, database.parent, Path(tempfile.gettempdir()), *(part for part in parts if part.is_dir()))
