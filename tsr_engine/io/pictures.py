"""Still pictures in: which files, and one at a time, with a limit on what a small file may unfold to."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np

from tsr_engine.errors import InputError
from tsr_engine.records import Picture

__all__ = ["MAX_PIXELS", "SUFFIXES", "find_pictures", "read_picture"]

SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".bmp", ".ppm", ".pgm", ".webp", ".tif", ".tiff"})
MAX_PIXELS = 100_000_000
_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def find_pictures(sources: Iterable[Path]) -> Iterator[Path]:
    """The pictures named, and those directly inside the folders named, in order.

    Raises:
        InputError: a source does not exist, or a folder has no pictures.
    """
    for source in sources:
        if not source.is_dir():
            if not source.exists():
                raise InputError(f"There is no picture or folder at {source}. Check the path.")
            yield source
            continue
        found = sorted(path for path in source.iterdir() if path.suffix.lower() in SUFFIXES and path.is_file())
        if not found:
            raise InputError(f"The folder {source} has no pictures ({', '.join(sorted(SUFFIXES))}). Choose another.")
        yield from found


def read_picture(path: Path) -> Picture:
    """Decode one picture as BGR, uint8, turned upright as its EXIF data says.

    Raises:
        InputError: missing, empty, not a picture, damaged, or over 100 million pixels.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"Cannot read the picture {path}: {error.strerror}. Check the file.") from None
    if not content:
        raise InputError(f"The picture {path} is empty (0 bytes). Copy it again from its source.")
    size = _announced_size(content)
    if size is not None and size[0] * size[1] > MAX_PIXELS:
        raise InputError(
            f"The picture {path} has {size[0]}x{size[1]} px, more than the limit of {MAX_PIXELS} pixels. Scale it down."
        )
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        picture = None
    if picture is None:
        raise InputError(f"{path} is not a picture that can be read, or is damaged. Convert it to JPEG or PNG.")
    return np.ascontiguousarray(picture, dtype=np.uint8)


def _announced_size(content: bytes) -> tuple[int, int] | None:
    """Width and height from the header of a PNG or JPEG, None for other formats."""
    if content.startswith(b"\x89PNG\r\n\x1a\n") and len(content) >= 24:
        width, height = struct.unpack(">II", content[16:24])
        return int(width), int(height)
    if not content.startswith(b"\xff\xd8"):
        return None
    at = 2
    while at + 9 <= len(content) and content[at] == 0xFF:
        marker, length = content[at + 1], int.from_bytes(content[at + 2 : at + 4], "big")
        if marker in _START_OF_FRAME:
            height, width = struct.unpack(">HH", content[at + 5 : at + 9])
            return int(width), int(height)
        at += 2 + length
    return None
