"""Pictures of labels: shipped ones are drawn on first use, others are stored in the database."""

from __future__ import annotations

import base64
import binascii
import hashlib
import io
import struct
import threading
from collections import OrderedDict
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from sqlalchemy.orm import Session

from app.errors import Invalid
from app.storage.database import Database
from app.storage.models import LabelPicture
from tsr_engine.pictograms import draw, names

MAX_BYTES: Final = 256 * 1024
MAX_SIDE: Final = 512
"""Pixels."""
_STORED = "sha256:"
_SIGNATURE = b"\x89PNG\r\n\x1a\n"


class Pictograms:
    """The pictures of labels as square PNG files."""

    def __init__(self, database: Database, max_cached: int = 1024) -> None:
        """Make an empty cache.

        Args:
            database: with the stored pictures.
            max_cached: number of cached files.
        """
        self._database = database
        self._max_cached = max_cached
        self._lock = threading.Lock()
        self._drawn: OrderedDict[tuple[str, int], bytes] = OrderedDict()

    def png(self, pictogram: str, size: int) -> bytes:
        """Return a picture, ``size`` px square, transparent around the sign.

        Args:
            pictogram: see ``Label.pictogram``.
            size: side, px.

        Raises:
            KeyError: no such picture.
        """
        key = pictogram, size
        with self._lock:
            if key in self._drawn:
                self._drawn.move_to_end(key)
                return self._drawn[key]
        picture = self._stored(pictogram, size) if pictogram.startswith(_STORED) else draw(pictogram, size)
        _, code = cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])
        content = code.tobytes()
        with self._lock:
            self._drawn[key] = content
            while len(self._drawn) > self._max_cached:
                self._drawn.popitem(last=False)
        return content

    def _stored(self, pictogram: str, size: int) -> NDArray[np.uint8]:
        with self._database.read() as session:
            row = session.get(LabelPicture, pictogram.removeprefix(_STORED))
        if row is None:
            raise KeyError(pictogram)
        picture = cv2.imdecode(np.frombuffer(row.png, np.uint8), cv2.IMREAD_UNCHANGED)
        assert picture is not None
        height, width = picture.shape[:2]
        scale = size / max(height, width)
        wanted = max(1, round(width * scale)), max(1, round(height * scale))
        fitted = cv2.resize(picture, wanted, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
        square = np.zeros((size, size, 4), np.uint8)
        top, left = (size - wanted[1]) // 2, (size - wanted[0]) // 2
        square[top : top + wanted[1], left : left + wanted[0]] = fitted
        return square


def picture_exists(session: Session, pictogram: str) -> bool:
    """Whether a picture with this name exists; the empty name means no picture and is valid."""
    if pictogram.startswith(_STORED):
        return session.get(LabelPicture, pictogram.removeprefix(_STORED)) is not None
    return not pictogram or pictogram in names()


def store_picture(session: Session, text: str) -> str:
    """Check a picture that a page has sent, and store it.

    Args:
        session: writes.
        text: a PNG file in base64.

    Returns:
        Its name for a label.

    Raises:
        Invalid: it is no PNG, or too large.
    """
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        raise Invalid("The picture is not valid base64.", field="png") from None
    content = _clean(data)
    digest = hashlib.sha256(content).hexdigest()
    if session.get(LabelPicture, digest) is None:
        session.add(LabelPicture(sha256=digest, png=content))
    return f"{_STORED}{digest}"


def _clean(data: bytes) -> bytes:
    """Encode the pixels again as RGBA, so that nothing else of the sent file is kept."""
    if len(data) > MAX_BYTES:
        raise Invalid(f"The picture has {len(data)} bytes; the limit is {MAX_BYTES}.", field="png")
    if not data.startswith(_SIGNATURE) or len(data) < 33:
        raise Invalid("The picture is not a PNG file.", field="png")
    width, height = struct.unpack(">II", data[16:24])
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise Invalid(f"The picture is {width} x {height} px; the limit is {MAX_SIDE} px per side.", field="png")
    try:
        with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            pixels = image.convert("RGBA")
    except (OSError, SyntaxError, ValueError) as error:
        raise Invalid(f"The picture is a damaged PNG file: {str(error).rstrip('.')}.", field="png") from None
    file = io.BytesIO()
    pixels.save(file, "PNG", optimize=True)
    return file.getvalue()
