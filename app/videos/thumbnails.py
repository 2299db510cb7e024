"""Paths of the files that an import writes."""

from __future__ import annotations

from pathlib import Path

__all__ = ["thumbnail_path"]


def thumbnail_path(home: Path, video_id: str) -> Path:
    """Path of the thumbnail of a video."""
    return home / "thumbnails" / f"{video_id}.jpg"
