"""The pinned decoder: one pass over one file with PyAV, its errors turned into counts and sentences."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import av
import cv2
import numpy as np
from av.video.frame import PictureType
from av.video.reformatter import VideoReformatter

from tsr_engine.errors import VideoError
from tsr_engine.io.opened_file import OpenedFile
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.io.video_probe import open_container, reason
from tsr_engine.records import Picture

# A demuxer that fails this often in a row will not find its way back into the file.
_PATIENCE = 8
_BIDIRECTIONAL = int(PictureType.B)
# H.264 allows 16 reference pictures; encoders that code everything bidirectionally would never stop waiting.
_LONGEST_RUN = 16


@dataclass(frozen=True, slots=True)
class Orientation:
    """How stored pictures are turned to stand upright: a transposition, then mirrorings."""

    transpose: bool = False
    flip_x: bool = False
    flip_y: bool = False

    @classmethod
    def of(cls, frame: Any) -> Orientation:
        """The orientation that a frame's display matrix names, to the nearest quarter turn.

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
        """The clockwise turn, 0, 90, 180 or 270; mirrorings aside."""
        if self.transpose:
            return 90 if self.flip_x else 270
        return 180 if self.flip_x and self.flip_y else 0


@dataclass(frozen=True, slots=True)
class Decoded:
    """One decoded picture that has not been converted to BGR yet."""

    stamp: int
    key: bool
    corrupt: bool
    raw: Any


def mark_damage(pictures: Iterator[Decoded]) -> Iterator[Decoded]:
    """Extend the corrupt flag to the pictures that are predicted from a damaged one.

    Those are all up to the next key frame, and the bidirectional pictures shown with it, which is why these wait for
    the next picture of another type. Concealment reads stale memory, so only pictures without the flag are the same
    in every run.
    """
    waiting: list[Decoded] = []
    tainted = False
    for picture in pictures:
        tainted = picture.corrupt or (tainted and not picture.key)
        waiting.append(replace(picture, corrupt=tainted))
        if picture.raw.pict_type == _BIDIRECTIONAL and len(waiting) <= _LONGEST_RUN:
            continue
        yield from _shared(waiting)
        waiting.clear()
    yield from _shared(waiting)


def _shared(group: list[Decoded]) -> list[Decoded]:
    """Pictures that may be predicted from each other: one that is damaged taints all but a key frame."""
    if not any(picture.corrupt for picture in group):
        return group
    return [picture if picture.key else replace(picture, corrupt=True) for picture in group]


class Decoder:
    """Pictures of one file in the decoder's output order, from the start or from a key frame.

    Attributes:
        packets: packets read since the start or the last ``seek``.
        discarded: those of them whose pictures an edit list hides.
        failed: packets that could not be read or decoded.
        tainted: damage has been met; it can leave marks in the decoder that outlive a search.
    """

    def __init__(self, file: OpenedFile, limits: VideoLimits) -> None:
        self.path = file.path
        self.packets = 0
        self.discarded = 0
        self.failed = 0
        self._stack = ExitStack()
        self.container, self.stream = self._stack.enter_context(open_container(file, limits))
        self.time_base = Fraction(self.stream.time_base)
        # AVI stores no presentation times, its demuxer guesses them, and without an index it counts decoding times
        # anew after each search. There a picture is known by the byte position of its packet.
        self.by_position = self.container.format.name == "avi"
        self.tainted = False
        self._lost = False
        self._reformatter = VideoReformatter()

    def close(self) -> None:
        """Close the file; closing twice is harmless."""
        self._stack.close()

    def seek(self, ticks: int) -> bool:
        """Go to the last place at or before ``ticks`` where decoding can start; false where that is impossible."""
        self.packets, self.discarded, self.failed = 0, 0, 0
        self._lost = False
        try:
            self.container.seek(ticks, stream=self.stream, backward=True)
        except (av.FFmpegError, OSError):
            return False
        return True

    def scan(self) -> Iterator[tuple[int, int, bool]]:
        """Stamp, ticks and key flag of every packet whose picture is to be shown.

        The ticks are presentation times, or decoding times in files without those.
        """
        for packet in self._packets():
            if packet.size and not packet.is_discard:
                ticks = packet.dts if self.by_position or packet.pts is None else packet.pts
                stamp = self._stamp(packet)
                if ticks is not None and stamp is not None:
                    yield stamp, int(ticks), bool(packet.is_keyframe)

    def _stamp(self, packet: Any) -> int | None:
        if self.by_position and packet.pos is not None:
            return int(packet.pos)
        stamp: int | None = packet.dts if self.by_position or packet.pts is None else packet.pts
        return stamp

    def __iter__(self) -> Iterator[Decoded]:
        return mark_damage(self._decoded())

    def _decoded(self) -> Iterator[Decoded]:
        for packet in self._packets():
            if packet.size:
                packet.pts = self._stamp(packet)
            for raw in self._decode(packet):
                if raw.pts is None:
                    self.failed += 1
                    self.tainted = True
                else:
                    self.tainted |= bool(raw.is_corrupt)
                    corrupt = bool(raw.is_corrupt) or self._lost
                    self._lost = False
                    yield Decoded(raw.pts, bool(raw.key_frame), corrupt, raw)

    def _packets(self) -> Iterator[Any]:
        failures = 0
        while failures < _PATIENCE:
            try:
                for packet in self.container.demux(self.stream):
                    failures = 0
                    self.packets += packet.size > 0
                    self.discarded += bool(packet.size and packet.is_discard)
                    yield packet
            except (av.FFmpegError, OSError):
                failures += 1
                self.failed += 1
            else:
                return
        yield av.Packet()

    def _decode(self, packet: Any) -> list[Any]:
        try:
            return list(self.stream.codec_context.decode(packet if packet.size else None))
        except EOFError:
            return []
        except MemoryError:
            raise VideoError(
                f"There is not enough memory to decode {self.path}. Close other programs or scale the video down."
            ) from None
        except (av.FFmpegError, OSError, ValueError):
            self.failed += 1
            self.tainted = self._lost = True
            return []

    def picture(self, decoded: Decoded, size: tuple[int, int], orientation: Orientation) -> Picture:
        """The upright BGR picture.

        Args:
            decoded: a picture of this decoder.
            size: (width, height) before the turn; a picture of another size is scaled to it.
            orientation: the turn to apply.

        Raises:
            VideoError: the pixel format cannot be converted.
        """
        raw = decoded.raw
        scaled = {} if (raw.width, raw.height) == size else {"width": size[0], "height": size[1]}
        try:
            pixels: Picture = self._reformatter.reformat(raw, format="bgr24", **scaled).to_ndarray()  # type: ignore[assignment]
        except (av.FFmpegError, ValueError, OSError) as error:
            raise VideoError(
                f"The pictures of {self.path} cannot be converted from {raw.format.name} ({reason(error)}). "
                "Convert the video to H.264 first."
            ) from None
        return orientation.apply(pixels)
