"""Invalid ZIP archives: entries that zipfile refuses in other ways, and endless lists."""

from __future__ import annotations

import struct
from collections.abc import Callable

__all__ = ["ARCHIVE_FAULTS", "archive_of_empty_files"]


def _changed(content: bytes, at: int, value: bytes) -> bytes:
    """An archive whose first list entry has other bytes at an offset."""
    place = content.index(b"PK\1\2") + at
    return content[:place] + value + content[place + len(value) :]


def _many_disks(content: bytes) -> bytes:
    place = content.rfind(b"PK\5\6")
    return content[:place] + struct.pack("<4sIQI", b"PK\6\7", 1, place, 2) + content[place:]


def _no_utf8(content: bytes) -> bytes:
    return _changed(_changed(content, 8, struct.pack("<H", 0x800)), 46, b"\xff")


ARCHIVE_FAULTS: dict[str, Callable[[bytes], bytes]] = {
    "a name that is no UTF-8": _no_utf8,
    "version needed 9.9": lambda content: _changed(content, 6, struct.pack("<H", 99)),
    "several disks": _many_disks,
}
"""Functions that make a valid archive invalid, by the fault."""


def archive_of_empty_files(entries: int) -> bytes:
    """An archive with only a list of empty files ``x`` and a valid end."""
    one = struct.pack("<4s6H3I5H2I", b"PK\1\2", 20, 20, 0, 0, 0, 33, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0) + b"x"
    size = entries * len(one)
    wide = struct.pack("<4sQHHIIQQQQ", b"PK\6\6", 44, 45, 45, 0, 0, entries, entries, size, 0)
    locator = struct.pack("<4sIQI", b"PK\6\7", 0, size, 1)
    unsaid = 0xFFFF, 0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF
    return one * entries + wide + locator + struct.pack("<4sHHHHIIH", b"PK\5\6", 0, 0, *unsaid, 0)
