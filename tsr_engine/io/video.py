"""Reads videos: frame k is the same picture by sequential decoding and by random access.

::

    with open_video("drive.mp4") as video:
        for frame in video.frames(ahead=4):
            print(frame.ordinal, frame.time, frame.picture.shape)
        frame = video.read(17)
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from tsr_engine.errors import UsageError, VideoError
from tsr_engine.io.frame_table import MIN_PART_DISTANCE, BoolArray, FrameLedger, FrameTable, IntArray
from tsr_engine.io.opened_file import OpenedFile, VideoSource, open_source
from tsr_engine.io.read_ahead import read_ahead
from tsr_engine.io.video_cursor import Cursor
from tsr_engine.io.video_decoder import Decoded, Decoder, Orientation
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.io.video_parts import ContainerLayout
from tsr_engine.io.video_probe import check_size, video_sha256
from tsr_engine.io.video_times import Scan, Timeline
from tsr_engine.io.video_warnings import DecodeCounts, HeaderInfo, VideoInfo
from tsr_engine.records import Picture

__all__ = ["Frame", "FrameTable", "Video", "VideoLimits", "open_video", "video_sha256"]


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One decoded frame.

    Attributes:
        ordinal: 0-based position in presentation order.
        time: presentation time in seconds, exact.
        picture: BGR, uint8, shape (height, width, 3), contiguous, upright.
        key: whether decoding can start here.
        corrupt: whether the decoder concealed damage in this picture or in one it may be predicted from; only pictures
            without the flag are the same in every run.
    """

    ordinal: int
    time: Fraction
    picture: Picture
    key: bool
    corrupt: bool

    @property
    def seconds(self) -> float:
        """``time`` as a float."""
        return float(self.time)


def open_video(path: VideoSource | str, *, limits: VideoLimits | None = None, table: FrameTable | None = None) -> Video:
    """Open a video file. Only its header and first picture are read.

    Args:
        path: a local file of one of the kinds in ``video_kinds.KINDS``, or an object that opens it. It is opened once:
            a file that replaces it later is never read.
        limits: limits on the file; unset: ``VideoLimits()``.
        table: the file's frame table from an earlier pass, whole or in part; makes random access fast from the start.

    Raises:
        VideoError: missing, not a video, without pictures, over the limits, or not the file of ``table``.
    """
    return Video(open_source(path), VideoLimits() if limits is None else limits, table)


class Video:
    """An open video file; a context manager. Created by ``open_video``.

    ``frames`` passes are independent of each other and of ``read``, which may be called from any thread.

    Attributes:
        file: the open file; closed with the video.
        path: the name that people see.
        width: px of the upright picture.
        height: px of the upright picture.
        rotation: clockwise rotation that makes stored pictures upright: 0, 90, 180 or 270 degrees.
        codec: name of the codec, such as ``h264``.
        rate: announced frames per second, for writing output; never used to find a frame.
        pixel_ratio: width of a pixel divided by its height, upright. If it is not 1, the picture is shown ``width``
            times this wide; coordinates are always in stored pixels.
    """

    def __init__(self, file: OpenedFile, limits: VideoLimits, table: FrameTable | None = None) -> None:
        self.file = file
        self.path = path = file.path
        self.limits = limits
        self._lock = threading.RLock()
        self._scanning = threading.Lock()
        self._scan: Scan | None = None
        self._counts: DecodeCounts | None = None
        decoder: Decoder | None = None
        try:
            decoder = Decoder(file, limits)
            if table is not None and table.time_base != decoder.time_base:
                raise VideoError(f"{path} does not belong to its frame table: other time base. Import it again.")
            self._ledger = FrameLedger(decoder.time_base, table)
            self._header_info = HeaderInfo.from_decoder(decoder)
            self.rate = self._header_info.rate
            self._timeline = Timeline(
                decoder.time_base, self.rate, decoder.kind.address, self._ledger, self._packet_scan
            )
            self._cursor = Cursor(file, limits, self._ledger, self._seek_to_key_frame, decoder)
            first = self._cursor.advance()
            if first is None:
                raise VideoError(f"{path} has no frame that can be decoded. Copy it again from its source.")
            check_size(path, int(first.raw.width), int(first.raw.height), limits)
            self.codec = str(decoder.stream.codec_context.codec.name)
            self._size = (int(first.raw.width), int(first.raw.height))
            self._orientation = Orientation.from_frame(first.raw)
            self.rotation = self._orientation.degrees
            self.width, self.height = self._size[:: -1 if self._orientation.transpose else 1]
            stored = Fraction(decoder.stream.sample_aspect_ratio or 1)
            self.pixel_ratio = 1 / stored if self._orientation.transpose else stored
        except BaseException:
            if decoder is not None:
                decoder.close()
            file.close()
            raise

    def __enter__(self) -> Video:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; closing twice is harmless."""
        with self._lock:
            self._cursor.close()
            self.file.close()

    @property
    def table(self) -> FrameTable:
        """The known frame table: confirmed rows, then rows predicted from a scan of the packets.

        The scan reads the file once without decoding (132,400 frames in about a second); ``confirm`` decodes.
        """
        with self._lock:
            confirmed = self._ledger.confirmed_stamps()
            expected, expected_keys = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_)
            if not self._ledger.complete:
                shown = self._timeline.in_display_order()
                is_expected = self._is_expected(shown, confirmed)
                expected, expected_keys = shown.stamps[is_expected], shown.keys[is_expected]
            return self._ledger.table(expected, expected_keys, self._timeline.ticks(expected))

    def _is_expected(self, shown: Scan, confirmed: IntArray) -> BoolArray:
        """Which packets are expected after the known frames; at least one frame is known."""
        if self._cursor.decoder.kind.address == "time":
            # Frames may share a stamp: the last one is the n-th with its stamp, and later packets are ahead.
            same_stamp = np.flatnonzero(shown.stamps == confirmed[-1])
            nth = min(int(np.count_nonzero(confirmed == confirmed[-1])), len(same_stamp))
            if not nth:
                return np.asarray(shown.ticks > confirmed[-1])
            return np.asarray(np.arange(len(shown.stamps)) > same_stamp[nth - 1])
        first = np.flatnonzero(shown.stamps == confirmed[0])
        return ~np.isin(shown.stamps, confirmed) & (np.arange(len(shown.stamps)) > (first[0] if len(first) else -1))

    @property
    def stamps_are_times(self) -> bool:
        """Whether the file stores presentation times, so that a frame's stamp is its time."""
        return self._timeline.stamps_are_times

    def adopt(self, table: FrameTable) -> bool:
        """Take over confirmed rows from an earlier pass over the same bytes, as if the file had been opened with them.

        Returns:
            Whether the table agrees with the known rows; if not, nothing is taken over.
        """
        return table.time_base == self._ledger.time_base and self._ledger.adopt(table)

    @property
    def position(self) -> int:
        """Ordinal of the last frame that ``read`` returned, from which decoding on is cheap; 0 at first."""
        return self._cursor.position

    @property
    def expected(self) -> int | None:
        """The best known number of frames, for progress: counted, else scanned, else announced, else None."""
        if self._ledger.complete:
            return len(self._ledger)
        return self._header_info.count if self._scan is None else len(self.table)

    @property
    def warnings(self) -> tuple[str, ...]:
        """One sentence for each problem of the file, as far as it has been read.

        Complete after ``confirm`` or a pass of ``frames`` to the end; empty before ``table`` is first read.
        """
        with self._lock:
            if self._ledger.complete and self._counts is None:
                self._packet_scan()
            if self._counts is None:
                return ()
            info = VideoInfo(
                path=self.path,
                kind=self._cursor.decoder.kind,
                header=self._header_info,
                layout=ContainerLayout.from_file(self.path, self._cursor.decoder.kind),
                counts=self._counts,
                timeline=self._timeline,
                scan=self._packet_scan(),
                table=self.table,
                pixel_ratio=self.pixel_ratio,
                width=self.width,
                height=self.height,
            )
            return info.messages()

    def confirm(self, progress: Callable[[int], None] | None = None) -> FrameTable:
        """Decode to the end, without converting pictures, and return the complete table.

        Args:
            progress: called with the number of confirmed frames after each one.

        Raises:
            VideoError: the file cannot be decoded.
        """
        if not self._ledger.complete:
            for _, k, _ in self._decode_range(max(0, len(self._ledger) - 1), None):
                if progress is not None:
                    progress(k + 1)
        return self.table

    def frames(
        self, start: int = 0, stop: int | None = None, *, ahead: int = 0, width: int | None = None
    ) -> Iterator[Frame]:
        """Yield frames ``start`` to ``stop - 1`` in presentation order.

        A start beyond the confirmed rows is reached by decoding, because only that shows which picture it is.

        Args:
            start: first ordinal, >= 0.
            stop: end, exclusive; unset or beyond the end: to the last frame.
            ahead: number of frames decoded in a background thread ahead of the consumer; 0: no thread.
            width: px, >= 1; wider pictures are shrunk to it during conversion, which is cheaper than shrinking them
                later, but gives other pixels than ``read``. Unset: full size.

        Raises:
            UsageError: the range is negative or starts beyond the end, or the width is not positive.
            VideoError: the file cannot be decoded, or differs from its table.
        """
        if start < 0 or (stop is not None and stop < start):
            raise UsageError(f"A range of frames must be 0 <= start <= stop. Got {start}:{stop}.")
        if width is not None and width < 1:
            raise UsageError(f"Pictures must be at least 1 px wide. Got {width}.")
        if ahead:
            return read_ahead(lambda: self._pictures(start, stop, width), ahead)
        return self._pictures(start, stop, width)

    def read(self, ordinal: int) -> Frame:
        """Read frame ``ordinal``: seek to a key frame and decode until the stamp of the table appears.

        Frames between the confirmed rows and a later frame are decoded once. Safe to call from several threads.

        Raises:
            UsageError: the frame does not exist.
            VideoError: the frame cannot be reached, or the file differs from its table.
        """
        with self._lock:
            inside = ordinal >= 0 and not (self._ledger.complete and ordinal >= len(self._ledger))
            decoded = self._go_to(self._cursor, ordinal) if inside else None
            if decoded is None:
                raise self._no_such_frame(ordinal)
            return self._frame(self._cursor.decoder, ordinal, decoded, self._size)

    def _pictures(self, start: int, stop: int | None, width: int | None) -> Iterator[Frame]:
        size = self._size
        if width is not None and width < self.width:
            upright = (width, max(1, round(self.height * width / self.width)))
            size = upright[::-1] if self._orientation.transpose else upright
        for decoder, k, decoded in self._decode_range(start, stop):
            yield self._frame(decoder, k, decoded, size)

    def _decode_range(self, start: int, stop: int | None) -> Iterator[tuple[Decoder, int, Decoded]]:
        """Yield decoded but unconverted frames of a range, with a separate decoder."""
        if start == stop:
            return
        cursor = Cursor(self.file, self.limits, self._ledger, self._seek_to_key_frame, Decoder(self.file, self.limits))
        try:
            decoded = self._go_to(cursor, start)
            if decoded is None:
                raise self._no_such_frame(start)
            while decoded is not None:
                yield cursor.decoder, cursor.position, decoded
                if stop is not None and cursor.position + 1 >= stop:
                    return
                decoded = cursor.advance()
            if cursor.from_start:
                self._counts = DecodeCounts.from_decoder(cursor.decoder)
        finally:
            cursor.close()

    def _frame(self, decoder: Decoder, k: int, decoded: Decoded, size: tuple[int, int]) -> Frame:
        picture = decoder.picture(decoded, size, self._orientation)
        time = self._timeline.tick(k) * self._ledger.time_base
        return Frame(k, time, picture, decoded.key, decoded.corrupt)

    def _go_to(self, cursor: Cursor, k: int) -> Decoded | None:
        if k < len(self._ledger):
            self._timeline.tick(k)  # finds whether times restart before frame k
        return cursor.go_to(k)

    def _seek_to_key_frame(self, decoder: Decoder, k: int) -> bool:
        """Seek a decoder to the key frame k."""
        stamp = self._ledger.stamp(k)
        if decoder.kind.address == "count":
            return decoder.seek_packet(stamp, self._packet_scan())
        if decoder.kind.address == "position":
            return decoder.seek(self._timeline.tick(k))
        # A seek by time may end in another part of a file whose times restart; an MP4 has one index.
        if not self._ledger.joined and (
            self._ledger.complete or decoder.kind.demuxer == "mov" or self._timeline.stamps_are_times
        ):
            return decoder.seek(stamp)
        earlier = int(np.count_nonzero(self._ledger.confirmed_stamps()[:k] == stamp))
        same_stamp = np.flatnonzero(self._packet_scan().stamps == stamp)
        if earlier >= len(same_stamp) or (np.diff(same_stamp) < MIN_PART_DISTANCE).any():
            return False
        return decoder.seek_index(int(same_stamp[earlier]))

    def _packet_scan(self) -> Scan:
        """All packets of the file, without decoding."""
        with self._scanning:
            if self._scan is None:
                decoder = Decoder(self.file, self.limits)
                try:
                    self._scan = Scan.from_packets(decoder.scan())
                    if self._counts is None:
                        self._counts = DecodeCounts.from_decoder(decoder)
                finally:
                    decoder.close()
            return self._scan

    def _no_such_frame(self, k: int) -> UsageError:
        return UsageError(f"{self.path} has frames 0 to {len(self._ledger) - 1}. Got {k}; choose one of those.")
