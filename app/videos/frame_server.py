"""The frame server of one open video: pictures on demand, and a thread that fills the cache around the last one."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import TypeVar

from app.errors import ApiError, Conflict
from app.videos.decoding import Decoder, Encoding
from app.videos.encoded import EncodedCache
from app.videos.previews import Previews, effort
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.records import Picture

__all__ = ["NEAR", "WIDTHS", "Encoding", "FrameServer", "FrameServerClosedError", "around"]

WIDTHS = (160, 320, 480, 640, 800, 960, 1120, 1280, 1600, 1920, 2560, 3840)
"""Widths that pictures are served at, besides their own."""
NEAR = 0.06
"""Seconds of decoding that are no reason for a preview."""
_AHEAD = 24
_SOON = 6
# Going back, whole blocks are decoded at once: each one costs a jump to a key frame.
_BLOCK = 8
_BLOCKS_BACK = 3


T = TypeVar("T")


class FrameServerClosedError(Exception):
    """The video was closed meanwhile; open it again."""


class FrameServer:
    """A decoder and its thread; safe to use from any thread.

    Attributes:
        table: the video's frame table.
        path: the file.
        status: what the file looked like when it was opened.
    """

    def __init__(
        self,
        video_id: str,
        video: Decoder,
        table: FrameTable,
        cache: EncodedCache,
        status: tuple[int, ...],
        previews: Previews,
    ) -> None:
        """Take an open video over.

        Args:
            video_id: the video.
            video: closed with the frame server.
            table: of the video.
            cache: of encoded pictures, shared.
            status: as above.
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
        self._wanted: tuple[int, int, Encoding] | None = None
        self._direction = 0
        self._waiting = 0
        self._closed = False
        self._thread = threading.Thread(target=self._run_ahead, name="tsr-frames", daemon=True)
        self._thread.start()

    def snap(self, width: int | None) -> int:
        """The width that a request for ``width`` px is served at.

        One of ``WIDTHS``, never more than the video's own.
        """
        own = self.video.width
        if width is None or width >= own:
            return own
        return min(own, next((w for w in WIDTHS if w >= width), own))

    def get(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        """The encoded picture, from the cache or decoded now; the thread goes on from there.

        Raises:
            Conflict: the file cannot be decoded there.
            FrameServerClosedError: the frame server was closed.
        """
        with self._request:
            last = self._wanted
            step = 0 if last is None else ordinal - last[0]
            self._direction = self._direction if not step else (step > 0) - (step < 0) if abs(step) <= _BLOCK else 0
            self._wanted = (ordinal, width, encoding)
            direction = self._direction
        data = self._cache.get((self._id, ordinal, width, encoding))
        if data is None:
            with self._turn():
                for k in range(self._first(ordinal, direction), ordinal + 1):
                    data = self._fill(k, width, encoding)
        with self._request:
            self._request.notify_all()
        assert data is not None
        return data

    def _first(self, ordinal: int, direction: int) -> int:
        """Where to begin keeping pictures on the way to one.

        A page asks for neighbours at once and they come here in any order: a picture that was passed without being kept
        would cost another jump to its key frame.
        """
        if direction < 0:
            return ordinal - ordinal % _BLOCK
        at = self.video.position
        if at < ordinal <= at + _BLOCK:
            return at + 1
        return max(self.table.key_at_or_before(ordinal) or 0, ordinal - _BLOCK + 1)

    def preview(self, ordinal: int, width: int, encoding: Encoding) -> bytes | None:
        """A small, soft picture at once; None where the picture itself is near, or no copy for scrubbing is made yet.

        The thread that decodes ahead stays where it is: whoever asks for a preview has not arrived.
        """
        if (self._id, ordinal, width, encoding) in self._cache:
            return None
        key = self.table.key_at_or_before(ordinal) or 0
        at = self.video.position
        steps = ordinal - at if key <= at <= ordinal else ordinal - key
        if effort(steps, self.video.width, self.video.height) < NEAR and not self._decoding.locked():
            return None
        if self._closed:
            raise FrameServerClosedError
        return self.previews.encoded(ordinal, width, encoding)

    def read(self, ordinal: int) -> Picture:
        """The decoded picture; errors as for ``get``."""
        with self._turn():
            return self._decoded(ordinal, lambda: self.video.picture(ordinal))

    def close(self) -> None:
        """Stop the thread and close the file; closing twice is harmless."""
        with self._request:
            self._closed = True
            self._request.notify_all()
        self._thread.join()
        with self._decoding:
            self.video.close()
        self.previews.close()

    def _turn(self) -> _Turn:
        return _Turn(self)

    def _decoded(self, ordinal: int, decode: Callable[[], T]) -> T:
        if self._closed:
            raise FrameServerClosedError
        try:
            return decode()
        except ApiError:
            raise
        except Exception as error:  # whatever a damaged file makes a library raise
            raise Conflict(f"Frame {ordinal} cannot be decoded: {error}", code="unreadable") from error

    def _fill(self, ordinal: int, width: int, encoding: Encoding) -> bytes:
        key = (self._id, ordinal, width, encoding)
        data = self._cache.get(key)
        if data is None:
            data = self._decoded(ordinal, lambda: self.video.encoded(ordinal, width, encoding))
            self._cache.put(key, data)
        return data

    def _run_ahead(self) -> None:
        request: tuple[int, int, Encoding] | None = None
        tried: set[int] = set()
        while True:
            with self._request:
                while not self._closed and (
                    self._waiting or self._wanted is None or self._left(tried, request) is None
                ):
                    self._request.wait()
                if self._closed or self._wanted is None:
                    return
                if self._wanted != request:
                    request, tried = self._wanted, set()
                k = self._left(tried, request)
            if k is None:
                continue
            tried.add(k)
            try:
                with self._decoding:
                    self._fill(k, request[1], request[2])
            except (ApiError, FrameServerClosedError):
                continue  # whoever asks for this frame is reported

    def _left(self, tried: set[int], request: tuple[int, int, Encoding] | None) -> int | None:
        """The next frame to decode for the present request.

        Frames that were tried for the same request are left out.
        """
        assert self._wanted is not None
        ordinal, width, encoding = self._wanted
        done = tried if request == self._wanted else set()
        for k in around(ordinal, self._direction, len(self.table)):
            if k not in done and (self._id, k, width, encoding) not in self._cache:
                return k
        return None


class _Turn:
    """A person's request: the thread waits until it is served."""

    def __init__(self, frame_server: FrameServer) -> None:
        self._frame_server = frame_server

    def __enter__(self) -> None:
        with self._frame_server._request:
            self._frame_server._waiting += 1
        self._frame_server._decoding.acquire()

    def __exit__(self, *_: object) -> None:
        self._frame_server._decoding.release()
        with self._frame_server._request:
            self._frame_server._waiting -= 1
            self._frame_server._request.notify_all()


def around(ordinal: int, direction: int, count: int) -> Iterator[int]:
    """Frames worth having next, the most urgent first.

    Args:
        ordinal: the frame on screen.
        direction: where the viewer goes: 1 forward, -1 back, 0 unknown.
        count: frames of the video.
    """
    ahead = range(ordinal + 1, min(ordinal + 1 + _AHEAD, count))
    if direction >= 0:
        yield from ahead[: _AHEAD if direction else _SOON]
    if direction <= 0:
        own = ordinal - ordinal % _BLOCK
        yield from range(own, ordinal)
        for back in range(1, _BLOCKS_BACK if direction else 2):
            yield from range(max(0, own - back * _BLOCK), max(0, own - (back - 1) * _BLOCK))
    if direction == 0:
        yield from ahead[_SOON:]
