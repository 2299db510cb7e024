"""Reads the outermost boxes of a file to find whether it is complete and whether it joins several videos."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final, TypeAlias

from tsr_engine.io.video_kinds import ASF_HEADER, Kind

Boxes: TypeAlias = Iterator[tuple[bytes, int | None]]
"""Name and end of each box, in bytes from the start of the file; None: the file does not state its end."""


@dataclass(frozen=True, slots=True)
class ContainerLayout:
    """Facts from the outermost boxes of a file.

    Attributes:
        starts: byte positions of the joined videos; the first is 0.
        is_complete: whether the boxes end within the file; None: the container has no boxes, or not their sizes.
    """

    starts: tuple[int, ...] = (0,)
    is_complete: bool | None = None

    @classmethod
    def from_file(cls, path: Path, kind: Kind) -> ContainerLayout:
        """Read the headers of a file's boxes."""
        if kind.demuxer not in _BOX_READERS:
            return cls()
        read_boxes, first_box, last_box = _BOX_READERS[kind.demuxer]
        with path.open("rb") as file:
            end = os.fstat(file.fileno()).st_size
            boxes = [(b"", end), *read_boxes(file, end)]
        ends = [0, *(stop for _, stop in boxes[1:])]
        later = [
            start for start, (name, _) in zip(ends, boxes[1:], strict=False) if name == first_box and start is not None
        ]
        name, stop = boxes[-1]
        return cls((0, *later[1:]), None if stop is None else stop <= end and last_box in (None, name))


def _iso_boxes(file: BinaryIO, end: int) -> Boxes:
    """Top-level boxes (ISO/IEC 14496-12, 4.2)."""
    at = 0
    while at + 8 <= end:
        file.seek(at)
        head = file.read(16)
        size, name = struct.unpack_from(">I4s", head)
        if size == 1 and len(head) == 16:
            size = struct.unpack_from(">Q", head, 8)[0]
        elif size == 0:
            size = end - at
        if size < 8:
            return
        at += size
        yield name, at


def _ebml_elements(file: BinaryIO, end: int) -> Boxes:
    """Top-level elements (RFC 8794): a header and a segment for each video."""
    at = 0
    while at + 2 <= end:
        file.seek(at)
        head = file.read(12)
        name = head[: 9 - head[0].bit_length()]
        first = head[len(name)] if len(name) < len(head) else 0
        length = 9 - first.bit_length()
        if len(name) > 4 or length > 8:
            return
        size = int.from_bytes(head[len(name) : len(name) + length], "big") - (1 << 7 * length)
        known = size < (1 << 7 * length) - 1  # unfinished recordings have other sizes
        at += len(name) + length + size
        yield name, at if known else None
        if not known:
            return


def _riff_boxes(file: BinaryIO, end: int) -> Boxes:
    """RIFF chunks by their form; a large AVI file has several, of which only the first is called ``AVI``."""
    at = 0
    while at + 12 <= end:
        file.seek(at)
        name, size, form = struct.unpack("<4sI4s", file.read(12))
        if name != b"RIFF":
            return
        known = 0 < size < 2**32 - 1  # headers of unfinished recordings have other sizes
        yield form, at + 8 + size if known else None
        if not known:
            return
        at += 8 + size + size % 2


def _flv_tags(file: BinaryIO, end: int) -> Boxes:
    """Headers and tags (Adobe Flash Video File Format, annex E)."""
    at = 0
    while at + 11 <= end:
        file.seek(at)
        head = file.read(11)
        if head[:4] == b"FLV\x01":
            at += int.from_bytes(head[5:9], "big") + 4
            yield b"FLV", at
        elif head[0] & 0x1F in (8, 9, 18):
            at += 11 + int.from_bytes(head[1:4], "big") + 4
            yield b"tag", at
        else:
            return


def _asf_objects(file: BinaryIO, end: int) -> Boxes:
    """Top-level objects (Advanced Systems Format, 2.1)."""
    at = 0
    while at + 24 <= end:
        file.seek(at)
        name, size = struct.unpack("<16sQ", file.read(24))
        yield name, at + size if size >= 24 else None
        if size < 24:  # an unfinished live recording
            return
        at += size


def _png_chunks(file: BinaryIO, end: int) -> Boxes:
    """Chunks (Portable Network Graphics, 5.3)."""
    at = 8
    while at + 12 <= end:
        file.seek(at)
        size, name = struct.unpack(">I4s", file.read(8))
        at += 12 + size
        yield name, at
        if name == b"IEND":
            return


def _gif_end(file: BinaryIO, end: int) -> Boxes:
    """The trailer, after which some programs write zeros (GIF89a, 27)."""
    file.seek(max(0, end - 256))
    yield b"trailer" if file.read().rstrip(b"\0").endswith(b";") else b"", end


_BOX_READERS: Final[dict[str, tuple[Callable[[BinaryIO, int], Boxes], bytes | None, bytes | None]]] = {
    "mov": (_iso_boxes, b"moov", None),
    "avi": (_riff_boxes, b"AVI ", None),
    "matroska": (_ebml_elements, b"\x1aE\xdf\xa3", None),
    "flv": (_flv_tags, b"FLV", None),
    "asf": (_asf_objects, ASF_HEADER, None),
    "apng": (_png_chunks, None, b"IEND"),
    "gif": (_gif_end, None, b"trailer"),
}
"""By demuxer: the function that reads the boxes, the box that occurs once a video, and the last box of a whole file."""
