"""Gives frames of a video in both directions: forwards as they are decoded, backwards by groups of pictures.

Stepping back frame by frame would decode a group of pictures from its key frame for each frame. This module decodes
the frames before the requested one together, and caches them up to a limit that does not depend on the video.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from itertools import islice
from typing import Final

import numpy as np

from tsr_engine.errors import UsageError
from tsr_engine.io.frame_table import BoolArray
from tsr_engine.io.video import Frame, Video

CACHE_BYTES: Final = 128 * 2**20
"""Size of the cache for going back, bytes."""
_MIN_CACHED: Final = 4
"""Least number of cached frames, whatever their size."""
_FIRST_BLOCK: Final = 8
"""Number of frames that are decoded together at first, so that the first one comes soon; it doubles each time."""
_MAX_SKIP: Final = 24
"""Largest distance to a later frame that is reached by decoding on."""
_MAX_RECENT: Final = 3
"""Number of recent frames that are cached too: each direction asks for the frame where it starts."""
_LOOKAHEAD: Final = 3
"""Number of frames that are decoded in the background."""


class BidirectionalFrames:
    """Gives frames by ordinal, cheaply for consecutive ordinals in either direction. A context manager.

    Args:
        video: an open video, which stays open.
        cache_bytes: size of the cache for going back, bytes.
    """

    def __init__(self, video: Video, cache_bytes: int = CACHE_BYTES) -> None:
        self._video = video
        self._max_block = max(_MIN_CACHED, cache_bytes // (video.width * video.height * 3))
        self._block_size = min(_FIRST_BLOCK, self._max_block)
        self._block: dict[int, Frame] = {}
        self._recent: OrderedDict[int, Frame] = OrderedDict()
        self._forward: Iterator[Frame] | None = None
        self._next = 0
        self._keys: BoolArray | None = None

    def __enter__(self) -> BidirectionalFrames:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Release all frames and the decoder."""
        self._stop_forward()
        self._block.clear()
        self._recent.clear()

    def __call__(self, ordinal: int) -> Frame | None:
        """Frame ``ordinal``; None: the video ends before it.

        Raises:
            VideoError: the frame cannot be decoded, or differs from the video's table.
        """
        if ordinal < 0:
            return None
        frame = self._recent.get(ordinal) or self._block.get(ordinal)
        if frame is None:
            backwards = ordinal + 1 in self._block or ordinal + 1 in self._recent
            frame = self._read_backward(ordinal) if backwards else self._read_forward(ordinal)
        if frame is not None:
            self._recent[ordinal] = frame
            self._recent.move_to_end(ordinal)
            if len(self._recent) > _MAX_RECENT:
                self._recent.popitem(last=False)
        return frame

    def prefetch(self, ordinal: int) -> None:
        """Decode the first frames that both directions from ``ordinal`` will need.

        Raises:
            UsageError: the frame does not exist.
            VideoError: as for reading a frame.
        """
        if ordinal not in self._recent and ordinal not in self._block:
            self._stop_forward()
            start = max(0, ordinal + 1 - self._block_size)
            self._forward, self._next = self._video.frames(start, ahead=_LOOKAHEAD), ordinal + 1
            self._block = {frame.ordinal: frame for frame in islice(self._forward, self._next - start)}
        self(ordinal)
        self(ordinal + 1)

    def _read_forward(self, ordinal: int) -> Frame | None:
        if self._forward is None or not self._next <= ordinal < self._next + _MAX_SKIP:
            self._stop_forward()
            self._forward, self._next = self._video.frames(ordinal, ahead=_LOOKAHEAD), ordinal
        try:
            for frame in self._forward:
                self._next = frame.ordinal + 1
                if frame.ordinal == ordinal:
                    return frame
        except UsageError:  # a range that begins beyond the end
            self._stop_forward()
        return None

    def _read_backward(self, ordinal: int) -> Frame | None:
        """Frame ``ordinal``, decoded together with the frames before it."""
        start = max(0, ordinal + 1 - self._block_size)
        self._block_size = min(2 * self._block_size, self._max_block)
        if self._keys is None:
            self._keys = self._video.table.key
        # Start at a key frame: frames between it and the first wanted one have to be decoded anyway.
        keys = np.flatnonzero(self._keys[start : ordinal + 1])
        if len(keys):
            start += int(keys[0])
        self._block.clear()
        self._block.update((frame.ordinal, frame) for frame in self._video.frames(start, ordinal + 1))
        return self._block.get(ordinal)

    def _stop_forward(self) -> None:
        close = getattr(self._forward, "close", None)
        if close is not None:
            close()
        self._forward = None
