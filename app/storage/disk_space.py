"""Checks that the disk of the data folder has free space."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Final

MIN_FREE_BYTES: Final = 16 * 2**20
"""Free bytes below which writing the database and files of jobs may fail."""


def shortage(home: Path) -> str | None:
    """Return a sentence if the disk of the data folder is full or nearly full; None: there is space."""
    try:
        free = shutil.disk_usage(home).free
    except OSError:
        return None  # writing there reports the error
    if free >= MIN_FREE_BYTES:
        return None
    return (
        f"The disk of the data folder is full: {free / 2**20:.0f} MiB are left. New work waits or fails, and what you "
        "change is kept in this page. Free some space."
    )
