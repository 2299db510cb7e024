"""ZIP archives written front to back: fixed dates and permissions, so that the same files give the same bytes.

For archives of 100,000 small files: an entry costs a fraction of what ``zipfile`` takes, and the list of entries
is kept as the bytes that it will be. Layout: PKWARE's APPNOTE 6.3.3, with ZIP64 where sizes or places ask for it.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from typing import IO, BinaryIO

from tsr_engine.io.pictures import SUFFIXES

__all__ = ["ZipWriter", "is_stored"]

_CHUNK = 1 << 20
_STORED = SUFFIXES - {".ppm", ".pgm", ".bmp"}
_TINY = 256
"""Bytes of a file that is not worth compressing."""
_SMALL = 1 << 12
"""Bytes of a file for which a compressor with a small window loses nothing and is set up in a tenth of the time."""
_LOCAL = struct.Struct("<4s5H3L2H")
_CENTRAL = struct.Struct("<4s6H3L5H2L")
_END = struct.Struct("<4s4H2LH")
_WIDE_END = struct.Struct("<4sQ2H2L4Q")
_LOCATOR = struct.Struct("<4sLQL")
_TOP16, _TOP32 = 0xFFFF, 0xFFFFFFFF
_DATE = 1 << 5 | 1
"""1 January 1980, the first day that a ZIP archive knows."""
_MADE_BY = 3 << 8 | 45
"""Unix, so that permissions count."""
_MODE = 0o100644 << 16
_DEFLATED = 8
_UTF8 = 0x800


def is_stored(name: str, size: int) -> bool:
    """Whether a file goes in as it is: tiny files and compressed pictures."""
    return size < _TINY or name[name.rfind(".") :].lower() in _STORED


class ZipWriter:
    """Writes one archive; ``close`` makes it whole."""

    def __init__(self, target: BinaryIO, pulse: Callable[[], None] = lambda: None) -> None:
        """Take an empty file.

        Args:
            target: seekable.
            pulse: called after each megabyte that was packed; raises to stop.
        """
        self._target = target
        self._pulse = pulse
        self._since = 0
        self._entries: list[bytes] = []
        self._at = 0

    def put(self, name: str, content: bytes) -> None:
        """A whole file."""
        stored = is_stored(name, len(content))
        packed = content if stored else _deflated(content)
        crc = zlib.crc32(content)
        self._write(self._local(name, stored, crc, len(packed), len(content), wide=False) + packed)
        self._enter(name, stored, crc, len(packed), len(content))
        self._count(len(content))

    def take(self, name: str, source: IO[bytes], size: int) -> None:
        """A file of any size, read from where it stands."""
        stored = is_stored(name, size)
        begin, crc, packed, done = self._at, 0, 0, 0
        # Compressing may add a little; the head must have room before the sizes are known.
        wide = size > _TOP32 - (size >> 8) - _CHUNK
        self._write(self._local(name, stored, 0, 0, 0, wide=wide))
        start = self._at
        compressor = None if stored else zlib.compressobj(6, zlib.DEFLATED, -15)
        while chunk := source.read(_CHUNK):
            crc = zlib.crc32(chunk, crc)
            done += len(chunk)
            self._write(chunk if compressor is None else compressor.compress(chunk))
            self._count(len(chunk))
        if compressor is not None:
            self._write(compressor.flush())
        packed = self._at - start
        self._target.seek(begin)
        self._target.write(self._local(name, stored, crc, packed, done, wide=wide))
        self._target.seek(self._at)
        self._enter(name, stored, crc, packed, done, begin)

    def close(self) -> None:
        """Write the list of entries."""
        begin, count = self._at, len(self._entries)
        for entry in self._entries:
            self._write(entry)
        size = self._at - begin
        if count >= _TOP16 or size >= _TOP32 or begin >= _TOP32:
            place = self._at
            self._write(_WIDE_END.pack(b"PK\x06\x06", 44, _MADE_BY, 45, 0, 0, count, count, size, begin))
            self._write(_LOCATOR.pack(b"PK\x06\x07", 0, place, 1))
        counted = min(count, _TOP16)
        self._write(_END.pack(b"PK\x05\x06", 0, 0, counted, counted, min(size, _TOP32), min(begin, _TOP32), 0))

    def _local(self, name: str, stored: bool, crc: int, packed: int, size: int, *, wide: bool) -> bytes:
        raw, flags = _encoded(name)
        extra = struct.pack("<2H2Q", 1, 16, size, packed) if wide else b""
        sizes = (_TOP32, _TOP32) if wide else (packed, size)
        method = 0 if stored else _DEFLATED
        head = _LOCAL.pack(
            b"PK\x03\x04", 45 if wide else 20, flags, method, 0, _DATE, crc, *sizes, len(raw), len(extra)
        )
        return head + raw + extra

    def _enter(self, name: str, stored: bool, crc: int, packed: int, size: int, begin: int = -1) -> None:
        raw, flags = _encoded(name)
        if begin < 0:
            begin = self._at - packed - _LOCAL.size - len(raw)
        wide = [value for value in (size, packed, begin) if value >= _TOP32]
        extra = struct.pack(f"<2H{len(wide)}Q", 1, 8 * len(wide), *wide) if wide else b""
        head = _CENTRAL.pack(
            b"PK\x01\x02",
            _MADE_BY,
            45 if wide else 20,
            flags,
            0 if stored else _DEFLATED,
            0,
            _DATE,
            crc,
            min(packed, _TOP32),
            min(size, _TOP32),
            len(raw),
            len(extra),
            0,
            0,
            0,
            _MODE,
            min(begin, _TOP32),
        )
        self._entries.append(head + raw + extra)

    def _write(self, content: bytes) -> None:
        self._target.write(content)
        self._at += len(content)

    def _count(self, size: int) -> None:
        self._since += size
        if self._since >= _CHUNK:
            self._since = 0
            self._pulse()


def _encoded(name: str) -> tuple[bytes, int]:
    raw = name.encode()
    return raw, 0 if len(raw) == len(name) else _UTF8


def _deflated(content: bytes) -> bytes:
    small = len(content) <= _SMALL
    compressor = zlib.compressobj(6, zlib.DEFLATED, -12 if small else -15, 5 if small else 8)
    return compressor.compress(content) + compressor.flush()
