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
"""Pictures from one key frame of the copy to the next."""
WIDTH = 640
"""Width of the copy at most, px."""
_CRF = 24
_RATE = Fraction(25)
_AHEAD = 8


def decode_all(file: Video, place: Path, tell: Callable[[int], None]) -> FrameTable:
    """Decode to the end, so that every frame is known to be there; begun anew after a kill.

    The copy is made in the same pass, since whoever opens the video next may leap to its end at once.

    Args:
        file: the video.
        place: where the copy for scrubbing goes, if the video is one that needs it.
        tell: called with the number of frames decoded; may raise.

    Raises:
        VideoError: the file cannot be decoded.
    """
    if is_wanted(file.table, file.width, file.height):
        # no room for a copy, or no way to encode one, is no reason to refuse the video
        with contextlib.suppress(StorageError, ExportError, OSError):
            _copy(file, place, tell)
    return file.confirm(tell)


def _copy(file: Video, place: Path, tell: Callable[[int], None]) -> None:
    width = min(WIDTH, file.width)
    height = max(1, round(file.height * width / file.width))
    place.parent.mkdir(parents=True, exist_ok=True)
    with VideoWriter(place, width, height, _RATE, crf=_CRF, preset="ultrafast", keys=KEYS) as copy:
        for frame in file.frames(ahead=_AHEAD, width=width):
            copy.write(frame.picture)
            tell(copy.frames)
