"""Reads still pictures: lists the files, and decodes one at a time with a limit on the decoded size."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, UnidentifiedImageError

from tsr_engine.errors import InputError
from tsr_engine.io.video_kinds import HEAD_BYTES, kind_of
from tsr_engine.records import Picture

SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".bmp", ".ppm", ".pgm", ".webp", ".tif", ".tiff"})
MAX_PIXELS = 100_000_000
_MAX_BYTES = 4 * MAX_PIXELS
"""Files up to this size cannot have too many pixels."""
_ORIENTATION = 0x0112
"""EXIF tag."""


def find_pictures(sources: Iterable[Path]) -> Iterator[Path]:
    """Yield the pictures among the sources, and those directly inside folders among them, in order.

    Raises:
        InputError: a source does not exist, or a folder has no pictures.
    """
    for source in sources:
        if not source.is_dir():
            if not source.exists():
                raise InputError(f"There is no picture or folder at {source}. Check the path.")
            yield source
            continue
        found = sorted(path for path in source.iterdir() if path.suffix.lower() in SUFFIXES and _is_listed(path))
        if not found:
            raise InputError(f"The folder {source} has no pictures ({', '.join(sorted(SUFFIXES))}). Choose another.")
        yield from found


def _is_listed(path: Path) -> bool:
    """Whether an entry of a folder is a file, or a link to nothing, which :func:`read_picture` then refuses."""
    return path.is_file() or (path.is_symlink() and not path.exists())


def read_picture(path: Path) -> Picture:
    """Decode one picture as BGR, uint8, shape (h, w, 3), turned upright by its EXIF data.

    Raises:
        InputError: missing, empty, not a picture, damaged, or over 100 million pixels.
    """
    try:
        with path.open("rb") as stream:
            content = stream.read(HEAD_BYTES)
            kind = kind_of(content)
            if kind is not None and kind.demuxer != "gif":  # a GIF may be either
                raise InputError(f"{path} is a video, not a picture. Use `tsr track` for videos.")
            content += stream.read(_MAX_BYTES - len(content) + 1)
    except OSError as error:
        raise InputError(f"Cannot read the picture {path}: {error.strerror}. Check the file.") from None
    if not content:
        raise InputError(f"The picture {path} is empty (0 bytes). Copy it again from its source.")
    pixels = _announced_pixels(content)
    if pixels > MAX_PIXELS or len(content) > _MAX_BYTES:
        raise InputError(f"The picture {path} has more than the limit of {MAX_PIXELS} pixels. Scale it down.")
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR) if pixels else None
    except cv2.error:
        picture = None
    if picture is None:
        raise InputError(f"{path} is not a picture that can be read, or is damaged. Convert it to JPEG or PNG.")
    return np.ascontiguousarray(picture, dtype=np.uint8)


def announced_size(path: Path) -> tuple[int, int] | None:
    """Width and height of a picture as :func:`read_picture` returns it, from its header; None: it cannot be read."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as picture:
                width, height = picture.size
                is_on_its_side = picture.getexif().get(_ORIENTATION, 1) in (5, 6, 7, 8)
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError, EOFError):
        return None
    return (height, width) if is_on_its_side else (width, height)


def _announced_pixels(content: bytes) -> int:
    """Width times height from a picture's header, before it is decompressed; 0: not a known picture."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of pictures that are large, or odd in a way that does not matter here
            with Image.open(io.BytesIO(content)) as picture:
                return picture.width * picture.height
    except Image.DecompressionBombError:
        return MAX_PIXELS + 1
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError, EOFError):
        return 0
