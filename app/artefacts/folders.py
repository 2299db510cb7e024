"""Folders of outputs. A folder counts only if its row says ``complete``; other content is left from broken work."""

from __future__ import annotations

import shutil
from pathlib import Path

from tsr_engine.io.unfinished import fsync_path

__all__ = ["artefact_folder", "clear_folder", "settle_file"]


def artefact_folder(home: Path, artefact_id: str) -> Path:
    """The folder of one artefact."""
    return home / "artefacts" / artefact_id


def clear_folder(home: Path, artefact_id: str) -> None:
    """Remove what an artefact has written so far."""
    shutil.rmtree(artefact_folder(home, artefact_id), ignore_errors=True)


def settle_file(path: Path) -> None:
    """Bring a finished file and its name to the disk."""
    for place in (path, path.parent):
        fsync_path(place)
