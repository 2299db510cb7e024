"""Preview frames: a small copy of a video with many key frames, shown while a person scrubs.

Seeking in a video with few key frames is slow: to show the last of 250 pictures, all of them are decoded. The copy has
a key frame every dozen pictures, so each is a few milliseconds away. The import makes it once. Its pictures are smaller
and softer than the video's, with the same ordinals; they are never used to judge a box.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np

from app.errors import Busy
from app.videos.checked_file import trusted_file
from app.videos.decoding import Decoder, Encoding
from tsr_engine.errors import TsrError, VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource

_SECONDS_A_PIXEL = 5.4e-9
"""Decoding time of one thread per pixel, s: 5 ms for 1280x720."""
MAX_SEEK_S = 0.15
"""Seconds that a person readily waits for a picture."""


def decoding_seconds(pictures: int, width: int, height: int) -> float:
    """Estimated time to decode pictures, s."""
    return pictures * width * height * _SECONDS_A_PIXEL


def needs_preview(table: FrameTable, width: int, height: int) -> bool:
    """Whether decoding the picture farthest from its key frame takes too long for scrubbing."""
    keys = np.flatnonzero(table.key)
    ends = np.append(keys[keys > 0], len(table))
    starts = np.append(0, keys[keys > 0])
    return decoding_seconds(int((ends - starts).max(initial=0)), width, height) > MAX_SEEK_S


class Previews:
    """The copy of one video, opened on first use; thread-safe.

    Args:
        path: path of the copy.
        count: number of pictures of the video itself.
        open_decoder: opens the copy.
    """

    def __init__(self, path: Path, count: int, open_decoder: Callable[[VideoSource], Decoder]) -> None:
        self._path = path
        self._count = count
        self._open_decoder = open_decoder
        self._lock = threading.Lock()
        self.decoder: Decoder | None = None
        self._closed = False

    def encoded(self, ordinal: int, width: int, encoding: Encoding) -> bytes | None:
        """Return the small picture as a file; None: there is no readable copy."""
        with self._lock:
            try:
                if self._closed or not self._is_open():
                    return None
                assert self.decoder is not None
                return self.decoder.encoded(ordinal, width, encoding)
            except Busy:
                return None
            except TsrError:
                self._release()  # its decoding process may have ended; the next call starts a new one
                return None

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._closed = True
            self._release()

    def _is_open(self) -> bool:
        if self.decoder is None and self._path.is_file():
            try:
                self.decoder = self._open_decoder(trusted_file(self._path))
                is_valid = self.decoder.frames == self._count
            except VideoError:
                is_valid = False
            if not is_valid:
                self._release()
                self._path.unlink(missing_ok=True)  # truncated, or written by another version: remove it
        return self.decoder is not None

    def _release(self) -> None:
        if self.decoder is not None:
            self.decoder.close()
            self.decoder = None
