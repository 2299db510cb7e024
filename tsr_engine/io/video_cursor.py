"""Moves through a video: steps forward, and seeks to any ordinal by key frame and time stamp."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tsr_engine.errors import VideoError
from tsr_engine.io.frame_table import FrameLedger
from tsr_engine.io.opened_file import OpenedFile
from tsr_engine.io.video_decoder import Decoded, Decoder
from tsr_engine.io.video_limits import VideoLimits

# Up to this distance, decoding on is faster than seeking.
_MAX_SKIP = 24
# Number of earlier key frames that a jump tries before it counts from the first frame.
_MAX_EARLIER_KEYS = 6
# Largest number of pictures that are shown before a key frame but follow it in the file.
_MAX_LEADING_PICTURES = 16


class _MismatchError(Exception):
    """The decoder's next frame is not the ledger's next row."""


class Cursor:
    """Moves one decoder over a video; compares every frame with a shared ledger, or adds it there.

    Attributes:
        position: ordinal of the current frame; -1 before the first.
        from_start: whether the decoder has run from the first packet without a jump, so that its counts cover the file.
    """

    def __init__(
        self,
        file: OpenedFile,
        limits: VideoLimits,
        ledger: FrameLedger,
        seek: Callable[[Decoder, int], bool],
        decoder: Decoder,
    ) -> None:
        """Start before the first frame.

        Args:
            file: the open file.
            limits: limits on the file if it is opened again.
            ledger: the confirmed frames.
            seek: seeks a decoder to a key frame by its ordinal; returns False if it cannot.
            decoder: a decoder at the start of the file; the cursor closes it.
        """
        self.decoder = decoder
        self.position = -1
        self.from_start = True
        self._file = file
        self._limits = limits
        self._ledger = ledger
        self._seek = seek
        self._current: Decoded | None = None
        self._pictures: Iterator[Decoded] = iter(self.decoder)

    def close(self) -> None:
        """Close the file; closing twice is harmless."""
        self._current = None
        self._pictures = iter(())
        self.decoder.close()

    def advance(self) -> Decoded | None:
        """The next frame; None: end of file.

        Raises:
            VideoError: the frame differs from the ledger.
        """
        try:
            return self.step()
        except _MismatchError:
            raise self._other_file_error() from None

    def go_to(self, k: int) -> Decoded | None:
        """Frame k; None: the video ends before it.

        A frame beyond the ledger is reached by decoding on from the ledger's end.

        Raises:
            VideoError: a frame on the way differs from the ledger.
        """
        known = min(k, len(self._ledger) - 1)
        if not self._is_reached_by_decoding(k, known):
            for start in self._start_frames(known):
                if self._jump(start, known):
                    break
            else:
                self._restart()
        while self.position < k:
            if self.advance() is None:
                return None
        return self._current

    def step(self) -> Decoded | None:
        """Decode the next picture; None: end of file."""
        decoded = next(self._pictures, None)
        if decoded is None:
            if not self._ledger.finish(self.position + 1):
                raise _MismatchError
            return None
        if not self._ledger.record(self.position + 1, decoded.stamp, decoded.key, decoded.corrupt):
            raise _MismatchError
        self.position += 1
        self._current = decoded
        return decoded

    def _is_reached_by_decoding(self, k: int, known: int) -> bool:
        """Whether frame k is reached by decoding on."""
        if self.position == k:
            return self._current is not None
        if not -1 <= self.position < k:
            return False
        start = self._ledger.start_at_or_before(known) if known >= 0 else None
        return k - self.position <= _MAX_SKIP or start is None or start <= self.position

    def _start_frames(self, k: int) -> Iterator[int]:
        """Key frames from which frame k decodes as in sequence, nearest first.

        A seek finds a stamp, so a key frame that shares its stamp with a neighbour is left out: the seek may find
        either. Concealment affects the decoder beyond the next key frame, so the pictures from the start to
        the key frame after it, and from the key frame before it, must be undamaged.
        """
        last = k
        for _ in range(_MAX_EARLIER_KEYS):
            start = self._ledger.start_at_or_before(last) if last >= 0 else None
            if start is None:
                return
            previous_key = self._ledger.key_at_or_before(start - 1) if start > 0 else start
            if not self._ledger.corrupt_between(start if previous_key is None else previous_key, last + 1):
                yield start
            last = start - 1

    def _jump(self, start: int, k: int) -> bool:
        """Seek to key frame ``start`` and decode to frame k; False if the decoder arrives elsewhere."""
        stamp = self._ledger.stamp(start)
        if self.decoder.has_damage or self._ledger.damaged:
            self._restart()
        self.from_start = False
        if not self._seek(self.decoder, start):
            return False
        self._pictures = iter(self.decoder)
        self._current = None
        # Pictures shown before a key frame may lack their references; later ones are past it. Packet numbers do not
        # separate them: there are at most as many as a decoder holds back.
        counts_packets = self.decoder.kind.address == "count"
        for seen, decoded in enumerate(self._pictures):
            if decoded.stamp == stamp and decoded.key:
                break
            if seen >= _MAX_LEADING_PICTURES if counts_packets else decoded.stamp > stamp:
                return False
        else:
            return False
        if not self._ledger.record(start, decoded.stamp, decoded.key, decoded.corrupt):
            return False
        self.position, self._current = start, decoded
        try:
            while self.position < k:
                if self.step() is None:
                    return False
        except _MismatchError:
            return False
        return True

    def _restart(self) -> None:
        self.decoder.close()
        self.decoder = Decoder(self._file, self._limits)
        self.position, self.from_start = -1, True
        self._current = None
        self._pictures = iter(self.decoder)

    def _other_file_error(self) -> VideoError:
        return VideoError(
            f"Frame {self.position + 1} of {self._file} is not the one in its frame table: the file has changed or "
            "the table is another file's. Import the video again."
        )
