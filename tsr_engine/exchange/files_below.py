"""What lies in a folder."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["files_below"]


def files_below(folder: Path) -> list[str]:
    """Names of all files in a folder and below, relative to it, with slashes, sorted; folders can hold 100,000."""
    out: list[str] = []
    waiting = [""]
    while waiting:
        prefix = waiting.pop()
        with os.scandir(f"{folder}/{prefix}") as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(f"{prefix}{entry.name}/")
                elif entry.is_file(follow_symlinks=False):
                    out.append(prefix + entry.name)
    return sorted(out)
