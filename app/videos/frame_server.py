"""The frame server of one open video: pictures on demand, and a thread that fills the cache around the last one."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from app.errors import ApiError, Conflict
from app.videos.decoding import Decoder, Encoding
from app.videos.picture_cache import PictureCache
from app.videos.previews import Previews, decoding_seconds
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.records import Picture

WIDTHS = (160, 320, 480, 640, 800, 960, 1120, 1280, 1600, 1920, 2560, 3840)
"""Widths in which pictures are served, besides their own."""
PREVIEW_THRESHOLD_S = 0.06
"""Seconds of decoding up to which no preview is sent."""
_PREFETCH_FRAMES = 24
_URGENT_FRAMES = 6
# Backwards, whole blocks are decoded at once, because each block needs a seek to a key frame.
_BLOCK = 8
_BLOCKS_BACKWARDS = 3


T = TypeVar("T")


class FrameServerClosedError(Exception):
    """The video was closed meanwhile; open it again."""


class FrameServer:
    """A decoder and its thread; thread-safe.

    Attributes:
        table: the video's frame table.
        path: the file.
        status: state of the file when it was opened.
    """

    def __init__(
        self,
        video_id: str,
        video: Decoder,
        table: FrameTable,
        cache: PictureCache,
        status: tuple[int, ...],
        previews: Previews,
    ) -> None:
        """Take ownership of an open video.

        Args:
            video_id: the video.
            video: closed with the frame server.
            table: frame table of the video.
            cache: shared cache of encoded pictures.
            status: state of the file.
            previews: the copy for scrubbing; closed with the frame server.
        """
        self.table = table
        self.status = status
        self.path = video.path
        self.previews = previews
        self._id = video_id
        self.video = video
        self._cache = cache
        self._decoding = threading.Lock()
        self._request = threading.Condition()
        self._requested: tuple[int, int, Encoding] | None = None
        self._direction = 0
        self._waiting = 0
        self._closed = False
        self._thread = threading.Thread(target=self._prefetch, name="tsr-frames", daemon=True)
        self._thread.start()

    def served_width(self, width: int | None) -> int:
        """Return the width in which a request for ``width`` px is served.

        It is one of ``WIDTHS``, and at most the video's own.
        """
        video_width = self.video.width
        if width is None or width >= video_width:
            return video_width
        return min(video_width, next((w for w in WIDTHS if w >= width), video_width))

    def get(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        """Return the encoded picture, cached or decoded now; the thread continues from there.

        Raises:
            Conflict: the file cannot be decoded there.
            FrameServerClosedError: the frame server was closed.
        """
        with self._request:
            last = self._requested
            step = 0 if last is None else ordinal - last[0]
            self._direction = self._direction if not step else (step > 0) - (step < 0) if abs(step) <= _BLOCK else 0
            self._requested = (ordinal, width, encoding)
            direction = self._direction
        data = self._cache.get((self._id, ordinal, width, encoding))
        if data is None:
            with self._foreground():
                for k in range(self._first_to_keep(ordinal, direction), ordinal + 1):
                    data = self._fill(k, width, encoding)
        with self._request:
            self._request.notify_all()
        assert data is not None
        return data

    def _first_to_keep(self, ordinal: int, direction: int) -> int:
        """First frame to keep on the way to a frame.

        A page requests neighbours at once, and they arrive in any order: a picture that was decoded without being kept
        would need another seek to its key frame.
        """
        if direction < 0:
            return ordinal - ordinal % _BLOCK
        at = self.video.position
        if at < ordinal <= at + _BLOCK:
            return at + 1
        return max(self.table.key_at_or_before(ordinal) or 0, ordinal - _BLOCK + 1)

    def preview(self, ordinal: int, width: int, encoding: Encoding) -> bytes | None:
        """Return a small, soft picture at once; None if decoding the frame is fast, or there is no copy for that yet.

        The thread does not move, because the person is still scrubbing.

        Raises:
            FrameServerClosedError: the frame server was closed.
        """
        if (self._id, ordinal, width, encoding) in self._cache:
            return None
        key = self.table.key_at_or_before(ordinal) or 0
        at = self.video.position
        steps = ordinal - at if key <= at <= ordinal else ordinal - key
        seconds = decoding_seconds(steps, self.video.width, self.video.height)
        if seconds < PREVIEW_THRESHOLD_S and not self._decoding.locked():
            return None
        if self._closed:
            raise FrameServerClosedError
        return self.previews.encoded(ordinal, width, encoding)

    def read(self, ordinal: int) -> Picture:
        """Return the decoded picture; errors as for ``get``."""
        with self._foreground():
            return self._decoded(ordinal, lambda: self.video.picture(ordinal))

    def close(self) -> None:
        """Stop the thread and close the file; safe to call again."""
        with self._request:
            self._closed = True
            self._request.notify_all()
        self._thread.join()
        with self._decoding:
            self.video.close()
        self.previews.close()

    @contextmanager
    def _foreground(self) -> Iterator[None]:
        """Decode for a person's request, for which the thread pauses."""
        with self._request:
            self._waiting += 1
        try:
            with self._decoding:
                yield
        finally:
            with self._request:
                self._waiting -= 1
                self._request.notify_all()

    def _decoded(self, ordinal: int, decode: Callable[[], T]) -> T:
        if self._closed:
            raise FrameServerClosedError
        try:
            return decode()
        except ApiError:
            raise
        except Exception as error:  # a damaged file can make a library raise anything
            raise Conflict(f"Frame {ordinal} cannot be decoded: {error}", code="unreadable") from error

    def _fill(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        key = (self._id, ordinal, width, encoding)
        data = self._cache.get(key)
        if data is None:
            data = self._decoded(ordinal, lambda: self.video.encoded(ordinal, width, encoding))
            self._cache.put(key, data)
        return data

    def _prefetch(self) -> None:
        request: tuple[int, int, Encoding] | None = None
        tried: set[int] = set()
        while True:
            with self._request:
                while not self._closed and (
                    self._waiting or self._requested is None or self._next_to_prefetch(tried, request) is None
                ):
                    self._request.wait()
                if self._closed or self._requested is None:
                    return
                if self._requested != request:
                    request, tried = self._requested, set()
                k = self._next_to_prefetch(tried, request)
            if k is None:
                continue
            tried.add(k)
            try:
                with self._decoding:
                    self._fill(k, request[1], request[2])
            except (ApiError, FrameServerClosedError):
                continue  # reported when somebody requests this frame

    def _next_to_prefetch(self, tried: set[int], request: tuple[int, int, Encoding] | None) -> int | None:
        """The next frame to decode ahead for the current request, without those already tried."""
        assert self._requested is not None
        ordinal, width, encoding = self._requested
        done = tried if request == self._requested else set()
        for k in prefetch_order(ordinal, self._direction, len(self.table)):
            if k not in done and (self._id, k, width, encoding) not in self._cache:
                return k
        return None


def prefetch_order(ordinal: int, direction: int, count: int) -> Iterator[int]:
    """Yield the frames to decode next, most urgent first.

    Args:
        ordinal: the displayed frame.
        direction: direction of the viewer: 1 forward, -1 back, 0 unknown.
        count: number of frames of the video.
    """
    following = range(ordinal + 1, min(ordinal + 1 + _PREFETCH_FRAMES, count))
    if direction >= 0:
        yield from following[: _PREFETCH_FRAMES if direction else _URGENT_FRAMES]
    if direction <= 0:
        block_start = ordinal - ordinal % _BLOCK
        yield from range(block_start, ordinal)
        for block in range(1, _BLOCKS_BACKWARDS if direction else 2):
            yield from range(max(0, block_start - block * _BLOCK), max(0, block_start - (block - 1) * _BLOCK))
    if direction == 0:
        yield from following[_URGENT_FRAMES:]
