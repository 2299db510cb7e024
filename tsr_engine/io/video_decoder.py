"""Decodes one file in one pass with the pinned PyAV; errors become counts and sentences."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain
from typing import Any

import av
import cv2
import numpy as np
from av.video.frame import PictureType
from av.video.reformatter import VideoReformatter

from tsr_engine.errors import VideoError
from tsr_engine.io.opened_file import OpenedFile
from tsr_engine.io.video_kinds import Kind
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.io.video_probe import error_reason, open_container
from tsr_engine.io.video_times import MIN_RESTART_S, NO_TIME, Scan
from tsr_engine.records import Picture

# Number of consecutive demuxer failures after which reading stops.
_MAX_FAILURES = 8
_B_PICTURE = int(PictureType.B)
# H.264 allows 16 reference pictures; without this limit, a stream of only bidirectional pictures waits for ever.
_MAX_B_RUN = 16
# Number of packets that may lack bytes after the first one that the demuxer marks.
_DAMAGED_PACKETS = 3
# Numbers of packets with positions by which a search by bytes goes back if it does not arrive otherwise.
_MAX_ANCHORS = 6


@dataclass(frozen=True, slots=True)
class Orientation:
    """The transposition and mirroring that make stored pictures upright."""

    transpose: bool = False
    flip_x: bool = False
    flip_y: bool = False

    @classmethod
    def from_frame(cls, frame: av.VideoFrame) -> Orientation:
        """The orientation in a frame's display matrix, to the nearest quarter turn.

        The matrix maps stored to displayed pixels, ``x' = a x + c y + tx``, ``y' = b x + d y + ty``, in rows
        ``(a, b, u), (c, d, v), (tx, ty, w)`` of 16.16 numbers (ISO/IEC 14496-12, 6.2.2).
        """
        data = next((entry for entry in frame.side_data if entry.type.name == "DISPLAYMATRIX"), None)
        if data is None:
            return cls()
        a, b, _, c, d, *_ = (int(value) for value in np.frombuffer(bytes(data), dtype=np.int32))
        if abs(b) + abs(c) > abs(a) + abs(d):
            return cls(True, c < 0, b < 0)
        return cls(False, a < 0, d < 0)

    def apply(self, picture: Picture) -> Picture:
        """The upright picture, contiguous."""
        if self.transpose:
            picture = cv2.transpose(picture)
        if self.flip_x or self.flip_y:
            picture = cv2.flip(picture, -1 if self.flip_x and self.flip_y else int(self.flip_x))
        return np.ascontiguousarray(picture)

    @property
    def degrees(self) -> int:
        """The clockwise rotation, 0, 90, 180 or 270, without mirroring."""
        if self.transpose:
            return 90 if self.flip_x else 270
        return 180 if self.flip_x and self.flip_y else 0


@dataclass(frozen=True, slots=True)
class Decoded:
    """A decoded picture before its conversion to BGR."""

    stamp: int
    key: bool
    corrupt: bool
    raw: av.VideoFrame


def mark_damage(pictures: Iterator[Decoded]) -> Iterator[Decoded]:
    """Extend the corrupt flag to pictures that are predicted from a damaged one.

    These are all pictures up to the next key frame, and the bidirectional pictures shown with it, which therefore wait
    for the next picture of another type. Concealment reads stale memory, so only pictures without the flag are the
    same in every run.
    """
    group: list[Decoded] = []
    tainted = False
    for picture in pictures:
        tainted = picture.corrupt or (tainted and not picture.key)
        group.append(replace(picture, corrupt=tainted))
        if picture.raw.pict_type == _B_PICTURE and len(group) <= _MAX_B_RUN:
            continue
        yield from _spread_damage(group)
        group.clear()
    yield from _spread_damage(group)


def _spread_damage(group: list[Decoded]) -> list[Decoded]:
    """Pictures that may be predicted from each other: a damaged one marks all but a key frame."""
    if not any(picture.corrupt for picture in group):
        return group
    return [picture if picture.key else replace(picture, corrupt=True) for picture in group]


def _has_no_duration(packet: av.Packet, kind: Kind) -> bool:
    """Whether an animation shows a picture for no time; players then show it for a default time."""
    if not kind.layered or not packet.size:
        return False
    if kind.demuxer == "webp":
        return bool(packet.is_untimed)
    data = bytes(packet)
    if kind.demuxer == "apng":  # a picture's control chunk comes first
        return data[4:8] == b"fcTL" and data[28:30] == b"\0\0"
    control = data.find(b"\x21\xf9\x04")  # the graphic control extension comes before the picture
    return 0 <= control <= len(data) - 6 and int.from_bytes(data[control + 4 : control + 6], "little") < 2


class Decoder:
    """Yields pictures of one file in the decoder's output order, from the start or from a key frame.

    Attributes:
        kind: kind of the file, and how its pictures are identified.
        packets: number of packets read since the start or the last seek.
        discarded: number of those whose pictures an edit list hides.
        untimed: number of those that the file shows for no time.
        failed: number of packets that could not be read or decoded, without those before the first key frame.
        sizes: width and height of the pictures decoded so far, with the stamp of the first picture of each size.
        has_damage: whether damage was met, which can affect the decoder beyond a seek.
    """

    def __init__(self, file: OpenedFile, limits: VideoLimits) -> None:
        self.path = file.path
        self._file = file
        self.sizes: dict[tuple[int, int], int] = {}
        self._limits = limits
        self._stack = ExitStack()
        self._reformatter = VideoReformatter()
        self._open()

    def _open(self) -> None:
        self.container, self.stream, self.kind = self._stack.enter_context(open_container(self._file, self._limits))
        self.time_base = Fraction(self.stream.time_base)
        self.has_damage = False
        self._reset_counts()

    def _reset_counts(self, count: int = 0) -> None:
        self.packets, self.discarded, self.untimed, self.failed = count, 0, 0, 0
        self._packet_lost = self._has_started = self._has_shown_picture = False
        self._next_packet: av.Packet | None = None
        self._incomplete_stamps: set[int] = set()

    def close(self) -> None:
        """Close the file; closing twice is harmless."""
        self._stack.close()

    def seek(self, ticks: int) -> bool:
        """Seek to the last place at or before ``ticks`` where decoding can start; False if that is impossible."""
        self._reset_counts()
        try:
            self.container.seek(ticks, stream=self.stream, backward=True)
        except (av.FFmpegError, OSError, OverflowError):
            return False
        return True

    def seek_index(self, number: int) -> bool:
        """Go to a packet by its index in the scan, without decoding earlier ones; False if there are fewer packets."""
        self.close()
        self._open()
        for packet in self._packets():
            if packet.size and not packet.is_discard and self._stamp(packet) is not None:
                if not number:
                    self._next_packet = packet
                    return True
                number -= 1
        return False

    def seek_packet(self, number: int, scan: Scan) -> bool:
        """Go to a packet by its number; False if the packets from there on differ from the scan.

        Which packet comes first after a seek by bytes depends on the layout of packets in the file. So the seek goes
        some packets further back, and counts from the first one identified by its position and size. The file's
        first packet is always identified.
        """
        last = int(np.searchsorted(scan.stamps, number, side="right"))
        anchors = np.flatnonzero(scan.positions[:last] >= 0)
        anchors_used = np.unique([*anchors[:1], *anchors[-_MAX_ANCHORS:]])
        number_by_position = {(int(scan.positions[k]), int(scan.sizes[k])): int(scan.stamps[k]) for k in anchors_used}
        for anchor in dict.fromkeys([*anchors_used[-1:], *anchors_used[1:2], *anchors_used[:1]]):
            try:
                self.container.seek(int(scan.positions[anchor]), unsupported_byte_offset=True)
            except (av.FFmpegError, OSError):
                continue
            self._reset_counts()
            current: int | None = None
            for packet in self._packets():
                found = number_by_position.get((packet.pos, packet.size)) if current is None and packet.size else None
                current = current + 1 if current is not None else found
                if current == number:
                    self._reset_counts(number + 1)
                    self._next_packet = packet
                    return True
                if current is None and packet.pos is not None and packet.pos > scan.positions[anchors_used[-1]]:
                    break
        return False

    def scan(self) -> Iterator[tuple[int, int, bool, int, int]]:
        """Yield one row for every packet whose picture is shown; see ``Scan.from_packets``."""
        for packet in self._packets():
            if packet.size and not packet.is_discard:
                stamp = self._stamp(packet)
                if stamp is not None:
                    ticks = packet.dts if self.kind.address == "position" or packet.pts is None else packet.pts
                    position = -1 if packet.pos is None else int(packet.pos)
                    ticks = NO_TIME if ticks is None else int(ticks)
                    yield stamp, ticks, bool(packet.is_keyframe), position, int(packet.size)

    def _stamp(self, packet: av.Packet) -> int | None:
        """The stamp that identifies the picture of a packet that has just been read."""
        if self.kind.address == "count":
            return self.packets - 1
        if self.kind.address == "position" and packet.pos is not None:
            return int(packet.pos)
        stamp: int | None = packet.dts if self.kind.address == "position" or packet.pts is None else packet.pts
        if stamp is None and packet.pos is not None:
            return NO_TIME + int(packet.pos)
        return stamp

    def __iter__(self) -> Iterator[Decoded]:
        return mark_damage(self._decoded())

    def _decoded(self) -> Iterator[Decoded]:
        for packet in self._stamped():
            self._has_started |= bool(packet.size and packet.is_keyframe)
            for raw in self.decode(packet):
                self._has_started = True
                if raw.pts is None:
                    self.failed += 1
                    self.has_damage = True
                else:
                    self.sizes.setdefault((int(raw.width), int(raw.height)), raw.pts)
                    corrupt = bool(raw.is_corrupt) or raw.pts in self._incomplete_stamps
                    self.has_damage |= corrupt
                    corrupt |= self._packet_lost
                    self._packet_lost = False
                    key = bool(raw.key_frame) and not (self.kind.layered and self._has_shown_picture)
                    self._has_shown_picture = True
                    yield Decoded(raw.pts, key, corrupt, raw)

    def _stamped(self) -> Iterator[av.Packet]:
        """Yield packets with their stamps, and record those of a transport stream that lack bytes by its counters.

        The demuxer's flag on one packet is about the next few too. It also flags undamaged ones where files are joined.
        """
        has_counters = self.kind.demuxer == "mpegts"
        waiting: deque[Any] = deque()  # Any: packets, which PyAV does not type; None follows the last
        damaged_left = undamaged_left = 0
        for packet in chain(self._packets(), [None] * _DAMAGED_PACKETS):
            if packet is not None:
                if packet.size:
                    packet.pts = self._stamp(packet)
                if waiting and self._times_restart(waiting[-1], packet):
                    undamaged_left = len(waiting) + 1
            waiting.append(packet)
            if len(waiting) <= _DAMAGED_PACKETS:
                continue
            first = waiting.popleft()
            damaged_left = (
                _DAMAGED_PACKETS if has_counters and first.is_corrupt and not undamaged_left else damaged_left - 1
            )
            undamaged_left -= 1 if undamaged_left else 0
            if damaged_left > 0 and first.size and first.pts is not None:
                self._incomplete_stamps.add(int(first.pts))
            yield first

    def _times_restart(self, last: av.Packet, packet: av.Packet) -> bool:
        """Whether decoding times go back from one packet to the next by more than damage explains."""
        if last.dts is None or packet.dts is None:
            return False
        return bool((last.dts - packet.dts) * self.time_base > MIN_RESTART_S)

    def _packets(self) -> Iterator[av.Packet]:
        failures = 0
        if self._next_packet is not None:
            packet_read_earlier, self._next_packet = self._next_packet, None
            yield packet_read_earlier
        while failures < _MAX_FAILURES:
            try:
                for packet in self.container.demux(self.stream):
                    failures = 0
                    self.packets += packet.size > 0
                    self.discarded += bool(packet.size and packet.is_discard)
                    self.untimed += _has_no_duration(packet, self.kind)
                    yield packet
            except (av.FFmpegError, OSError):
                failures += 1
                self.failed += 1
            else:
                return
        yield av.Packet()

    def decode(self, packet: av.Packet) -> list[av.VideoFrame]:
        """Pictures that a packet completes; an empty packet flushes the last ones."""
        try:
            return list(self.stream.codec_context.decode(packet if packet.size else None))
        except EOFError:
            return []
        except MemoryError:
            raise VideoError(
                f"There is not enough memory to decode {self.path}. Close other programs or scale the video down."
            ) from None
        except (av.FFmpegError, OSError, ValueError):
            if self._has_started:  # pictures before the first key frame cannot be decoded, even if undamaged
                self.failed += 1
                self.has_damage = self._packet_lost = True
            return []

    def picture(self, decoded: Decoded, size: tuple[int, int], orientation: Orientation) -> Picture:
        """Convert a picture to upright BGR, uint8, shape (h, w, 3).

        Args:
            decoded: a picture of this decoder.
            size: (width, height) before the rotation; a picture of another size is scaled to it.
            orientation: the rotation to apply.

        Raises:
            VideoError: the pixel format cannot be converted.
        """
        raw = decoded.raw
        scaled = {} if (raw.width, raw.height) == size else {"width": size[0], "height": size[1]}
        try:
            pixels: Picture = self._reformatter.reformat(raw, format="bgr24", **scaled).to_ndarray()  # type: ignore[assignment]
        except (av.FFmpegError, ValueError, OSError) as error:
            raise VideoError(
                f"The pictures of {self.path} cannot be converted from {raw.format.name} ({error_reason(error)}). "
                "Convert the video to H.264 first."
            ) from None
        return orientation.apply(pixels)
