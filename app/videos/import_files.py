"""Paths of the files that an import writes."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path


def thumbnail_path(home: Path, video_id: str) -> Path:
    """Path of the thumbnail of a video."""
    return home / "thumbnails" / f"{video_id}.jpg"


def preview_path(home: Path, video_id: str) -> Path:
    """Path of the small copy of a video for scrubbing; it need not exist."""
    return home / "glances" / f"{video_id}.mp4"


def import_files(home: Path, video_id: str) -> tuple[Path, Path]:
    """Paths of all files that the import of a video may have written."""
    return thumbnail_path(home, video_id), preview_path(home, video_id)


def clear_import(home: Path, video_id: str) -> None:
    """Remove the files that the import of a video has written."""
    for path in import_files(home, video_id):
        with suppress(OSError):
            path.unlink(missing_ok=True)
