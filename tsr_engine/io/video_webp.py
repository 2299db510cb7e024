"""Reads animated WebP behind the interface of a PyAV container; Pillow decodes it, because FFmpeg 8 cannot."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import BinaryIO

import av
import numpy as np

_DEFAULT_DURATION_MS = 100
"""Milliseconds for which browsers show a picture without a duration."""


@dataclass(slots=True)
class _Packet:
    """One picture of the file, with the parts of a packet that the decoder uses."""

    pos: int | None
    size: int
    pts: int | None
    dts: int | None
    number: int
    is_untimed: bool = False
    is_discard: bool = False
    is_corrupt: bool = False

    @property
    def is_keyframe(self) -> bool:
        """Pictures are merged into each other, so decoding starts at the first."""
        return self.number == 0


class WebpFile:
    """An open file with the parts of ``av.container.InputContainer`` and of a stream's codec that the decoder uses."""

    def __init__(self, stream: Callable[[], BinaryIO], check: Callable[[int, int], None]) -> None:
        """Read the list of pictures.

        Args:
            stream: opens a separate stream of the bytes from the beginning.
            check: called with width and height before a picture is allocated; raises if they are too large.

        Raises:
            ValueError: the list is damaged.
            OSError: the file cannot be read, or is cut short.
        """
        with stream() as file:
            head = file.read(30)
            if len(head) < 30:
                raise ValueError("its header is cut off")
            self.width, self.height = (int.from_bytes(head[at : at + 3], "little") + 1 for at in (24, 27))
            check(self.width, self.height)
            self._packets = list(_pictures(file))
        from PIL import Image  # other files do not need it

        self._bytes = stream()
        try:
            self._picture = Image.open(self._bytes, formats=["WEBP"])
        except BaseException:
            self._bytes.close()
            raise
        self.format = SimpleNamespace(name="webp")
        self.codec = SimpleNamespace(name="webp")
        self.streams = _Streams(self._stream())
        self.duration = None
        self.options: dict[str, str] = {}

    def __enter__(self) -> WebpFile:
        return self

    def __exit__(self, *_: object) -> None:
        self._picture.close()
        self._bytes.close()

    def _stream(self) -> SimpleNamespace:
        ends = [packet.pts or 0 for packet in self._packets[:1] + self._packets[-1:]]
        steps = len(self._packets) - 1
        rate = Fraction(1000 * steps, ends[1] - ends[0]) if steps and ends[1] > ends[0] else Fraction(25)
        return SimpleNamespace(
            time_base=Fraction(1, 1000),
            average_rate=rate,
            guessed_rate=rate,
            duration=None,
            frames=len(self._packets),
            index_entries=self._packets,
            sample_aspect_ratio=None,
            codec_context=self,
            disposition=av.stream.Disposition(0),
        )

    def seek(self, offset: int, **_: object) -> None:
        """Do nothing: decoding can start only at the first picture, where ``demux`` begins anyway."""

    def demux(self, _: object) -> Iterator[_Packet]:
        """Yield all pictures in order, then an empty packet."""
        for packet in self._packets:
            yield _Packet(**{name: getattr(packet, name) for name in _Packet.__slots__})
        yield _Packet(None, 0, None, None, len(self._packets))

    def decode(self, packet: _Packet | None) -> list[av.VideoFrame]:
        """The picture of a packet, merged with those before it.

        Raises:
            OSError: the picture is damaged.
        """
        if packet is None:
            return []
        self._picture.seek(packet.number)
        frame = av.VideoFrame.from_ndarray(np.asarray(self._picture.convert("RGB")), format="rgb24")
        frame.pts = packet.pts
        frame.key_frame = packet.is_keyframe  # type: ignore[attr-defined]
        return [frame]


class _Streams(list[SimpleNamespace]):
    def __init__(self, stream: SimpleNamespace) -> None:
        super().__init__([stream])
        self.video, self.audio = [stream], list[SimpleNamespace]()


def _pictures(file: BinaryIO) -> Iterator[_Packet]:
    """Yield the ``ANMF`` chunks (WebP container specification) with their display times."""
    file.seek(12)
    time = number = 0
    while len(head := file.read(8)) == 8:
        name, size = struct.unpack("<4sI", head)
        position = file.tell()
        if name == b"ANMF":
            chunk_head = file.read(16)
            if len(chunk_head) < 16:
                return
            duration = int.from_bytes(chunk_head[12:15], "little")
            yield _Packet(position - 8, size, time, time, number, is_untimed=duration == 0)
            time += duration or _DEFAULT_DURATION_MS
            number += 1
        file.seek(position + size + size % 2)
