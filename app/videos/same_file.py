"""Whether a file is still the one that a video is named after."""

from __future__ import annotations

from pathlib import Path

from app.storage.models import Video
from app.videos.table import modified
from tsr_engine.io.video_probe import video_sha256

__all__ = ["is_same", "is_untouched"]


def is_untouched(video: Video, path: Path) -> bool:
    """Whether size and time of change of a file are those of when the frame table was made; its bytes are not read."""
    try:
        found = path.stat()
    except OSError:
        return False
    stamp = -1 if video.frame_table is None else modified(video.frame_table)
    return stamp >= 0 and (found.st_size, found.st_mtime_ns) == (video.size, stamp)


def is_same(video: Video, path: Path) -> bool:
    """Whether a file has the video's bytes. They are read where only the time of change is another: it may be a copy.

    Raises:
        VideoError: it is missing or cannot be read.
    """
    return is_untouched(video, path) or video_sha256(path) == video.id
