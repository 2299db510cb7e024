"""Writes the small copy that ``app.videos.previews`` reads, during the import's pass over the video."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from app.videos.previews import needs_preview
from tsr_engine.errors import ExportError, StorageError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video import Video
from tsr_engine.io.video_writer import VideoWriter

KEY_FRAME_INTERVAL = 12
"""Distance of key frames in the copy, frames."""
MAX_WIDTH = 640
"""Maximum width of the copy, px."""
_CRF = 24
_RATE = Fraction(25)
_PREFETCH_FRAMES = 8


def decode_all(file: Video, preview_path: Path, progress: Callable[[int], None]) -> FrameTable:
    """Decode the whole video, so that every frame is known to exist; an interrupted import starts over.

    The copy for scrubbing is made in the same pass, because the next viewer may jump to the end at once.

    Args:
        file: the video.
        preview_path: path of the copy for scrubbing, if the video needs one.
        progress: called with the number of frames decoded; may raise.

    Returns:
        The frame table.

    Raises:
        VideoError: the file cannot be decoded.
    """
    if needs_preview(file.table, file.width, file.height):
        # do not refuse the video if there is no space for a copy or no encoder
        with contextlib.suppress(StorageError, ExportError, OSError):
            _copy(file, preview_path, progress)
    return file.confirm(progress)


def _copy(file: Video, preview_path: Path, progress: Callable[[int], None]) -> None:
    width = min(MAX_WIDTH, file.width)
    height = max(1, round(file.height * width / file.width))
    preview_path.parent.mkdir(parents=True, exist_ok=True)
    with VideoWriter(
        preview_path, width, height, _RATE, crf=_CRF, preset="ultrafast", key_distance=KEY_FRAME_INTERVAL
    ) as copy:
        for frame in file.frames(ahead=_PREFETCH_FRAMES, width=width):
            copy.write(frame.picture)
            progress(copy.frames)
