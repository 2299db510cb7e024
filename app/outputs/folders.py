"""Folders of outputs. A folder counts only if its row says ``complete``; other content is left from unfinished work."""

from __future__ import annotations

import shutil
from pathlib import Path

from tsr_engine.io.unfinished import fsync_path


def output_folder(home: Path, output_id: str) -> Path:
    """The folder of one output."""
    return home / "artefacts" / output_id


def clear_folder(home: Path, output_id: str) -> None:
    """Remove the files that an output has written so far."""
    shutil.rmtree(output_folder(home, output_id), ignore_errors=True)


def sync_file(path: Path) -> None:
    """Sync a finished file and its folder entry to the disk."""
    for entry in (path, path.parent):
        fsync_path(entry)
