"""Places of the files that an import writes."""

from __future__ import annotations

from pathlib import Path

__all__ = ["thumbnail_path"]


def thumbnail_path(home: Path, video_id: str) -> Path:
    """Where the thumbnail of a video lies."""
    return home / "thumbnails" / f"{video_id}.jpg"
