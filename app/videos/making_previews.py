"""Writes the small copy that ``app.videos.previews`` reads, during the import's pass over the video."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from app.videos.previews import is_wanted
from tsr_engine.errors import ExportError, StorageError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video import Video
from tsr_engine.io.video_writer import VideoWriter

__all__ = ["KEYS", "WIDTH", "decode_all"]

KEYS = 12
"""Distance of key frames in the copy, frames."""
WIDTH = 640
"""Maximum width of the copy, px."""
_CRF = 24
_RATE = Fraction(25)
_AHEAD = 8


def decode_all(file: Video, place: Path, progress: Callable[[int], None]) -> FrameTable:
    """Decode the whole video, so that every frame is known to exist; an interrupted import starts over.

    The copy for scrubbing is made in the same pass, because the next viewer may jump to the end at once.

    Args:
        file: the video.
        place: path of the copy for scrubbing, if the video needs one.
        progress: called with the number of frames decoded; may raise.

    Returns:
        The frame table.

    Raises:
        VideoError: the file cannot be decoded.
    """
    if is_wanted(file.table, file.width, file.height):
        # do not refuse the video if there is no space for a copy or no encoder
        with contextlib.suppress(StorageError, ExportError, OSError):
            _copy(file, place, progress)
    return file.confirm(progress)


def _copy(file: Video, place: Path, progress: Callable[[int], None]) -> None:
    width = min(WIDTH, file.width)
    height = max(1, round(file.height * width / file.width))
    place.parent.mkdir(parents=True, exist_ok=True)
    with VideoWriter(place, width, height, _RATE, crf=_CRF, preset="ultrafast", key_distance=KEYS) as copy:
        for frame in file.frames(ahead=_AHEAD, width=width):
            copy.write(frame.picture)
            progress(copy.frames)
