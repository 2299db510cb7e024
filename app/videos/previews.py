"""Preview frames: a small copy of a video with many key frames, shown while a person scrubs.

Pictures of a video with few key frames take long to reach: to show the last of 250, all of them are decoded. The copy
has a key frame every dozen pictures, so each is a few milliseconds away. It is made once, by the import; its
pictures are smaller and softer than the video's, bear the same ordinals, and are never what a box is judged by.
"""

from __future__ import annotations

import threading
from pathlib import Path

import numpy as np

from app.videos.opened import own_file
from tsr_engine.errors import VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video import open_video
from tsr_engine.records import Picture

__all__ = ["Previews", "effort", "is_wanted", "preview_path"]

_SECONDS_A_PIXEL = 5.4e-9
"""Decoding, one thread: 5 ms for 1280x720."""
_WORST = 0.15
"""Seconds that a viewer waits gladly for a picture."""


def preview_path(home: Path, video_id: str) -> Path:
    """Where the copy of a video lies, if there is one."""
    return home / "glances" / f"{video_id}.mp4"


def effort(pictures: int, width: int, height: int) -> float:
    """About how long so many pictures take to decode, s."""
    return pictures * width * height * _SECONDS_A_PIXEL


def is_wanted(table: FrameTable, width: int, height: int) -> bool:
    """Whether the picture farthest from its key frame is too far for a viewer who scrubs."""
    keys = np.flatnonzero(table.key)
    ends = np.append(keys[keys > 0], len(table))
    starts = np.append(0, keys[keys > 0])
    return effort(int((ends - starts).max(initial=0)), width, height) > _WORST


class Previews:
    """The open copy; safe to use from any thread."""

    def __init__(self, path: Path, count: int) -> None:
        """Open it.

        Args:
            path: the copy.
            count: pictures of the video itself.

        Raises:
            VideoError: it cannot be read, or is not a copy of that many pictures.
        """
        self._lock = threading.Lock()
        copy = own_file(path)
        with open_video(copy) as scanned:
            table = scanned.table
        if len(table) != count:
            raise VideoError(f"{path} has {len(table)} pictures, not {count}.")
        self._video = open_video(copy, table=table)

    def read(self, ordinal: int) -> Picture:
        """The small picture, BGR.

        Raises:
            VideoError: it cannot be decoded.
        """
        with self._lock:
            return self._video.read(ordinal).picture

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._video.close()
