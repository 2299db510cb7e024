"""Pictures of labels: drawn and stored ones, and refused files."""

from __future__ import annotations

import base64
import io
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image, PngImagePlugin

from app.errors import Invalid
from app.labels.pictures import MAX_BYTES, Pictograms, picture_exists, store_picture
from app.storage.database import Database
from app.storage.models import LabelPicture
from tests.app.databases import put_tables


@pytest.fixture
def sqlite(tmp_path: Path) -> Iterator[Database]:
    put_tables(tmp_path / "tsr.sqlite")
    database = Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")
    yield database
    database.close()


def png(width: int, height: int, mode: str = "RGB", **options: object) -> bytes:
    file = io.BytesIO()
    Image.new(mode, (width, height), "red" if mode == "RGB" else None).save(file, "PNG", **options)
    return file.getvalue()


def text(data: bytes) -> str:
    return base64.b64encode(data).decode()


def pixels(content: bytes) -> np.ndarray:
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    return picture


def test_pictograms_differ_and_are_transparent_around_the_sign(sqlite: Database) -> None:
    drawn = Pictograms(sqlite)
    pictures = [pixels(drawn.png(f"gtsrb/{c}", 48)) for c in range(43)]
    assert {picture.shape for picture in pictures} == {(48, 48, 4)}
    assert len({picture.tobytes() for picture in pictures}) == 43
    for picture in pictures:
        assert picture[0, 0, 3] == 0
        assert picture[24, 24, 3] == 255


def test_pictograms_are_drawn_once(sqlite: Database) -> None:
    drawn = Pictograms(sqlite, max_cached=2)
    first = drawn.png("gtsrb/1", 32)
    assert drawn.png("gtsrb/1", 32) is first
    drawn.png("gtsrb/2", 32), drawn.png("gtsrb/3", 32)
    assert drawn.png("gtsrb/1", 32) == first
    for name in ("gtsrb/43", "nothing", "sha256:" + "0" * 64):
        with pytest.raises(KeyError):
            drawn.png(name, 32)


def test_a_stored_picture_is_shown_square_and_kept_once(sqlite: Database) -> None:
    with sqlite.write() as session:
        name = store_picture(session, text(png(40, 20)))
        assert store_picture(session, text(png(40, 20))) == name
        assert picture_exists(session, name)
        assert not picture_exists(session, "sha256:" + "0" * 64)
    shown = pixels(Pictograms(sqlite).png(name, 64))
    assert shown.shape == (64, 64, 4)
    assert shown[32, 32].tolist() == [0, 0, 255, 255]
    assert shown[4, 32, 3] == 0  # the margins of a wide picture are transparent


@pytest.mark.parametrize("mode", ["L", "LA", "P", "RGB", "RGBA", "1", "I;16"])
def test_every_kind_of_png_becomes_rgba(sqlite: Database, mode: str) -> None:
    with sqlite.write() as session:
        name = store_picture(session, text(png(9, 9, mode)))
        row = session.get(LabelPicture, name.removeprefix("sha256:"))
        assert row is not None
        with Image.open(io.BytesIO(row.png)) as image:
            assert image.mode == "RGBA"
            assert image.size == (9, 9)


def test_only_pixels_are_kept(sqlite: Database) -> None:
    info = PngImagePlugin.PngInfo()
    info.add_text("comment", "where I live")
    with sqlite.write() as session:
        name = store_picture(session, text(png(9, 9, pnginfo=info)))
        row = session.get(LabelPicture, name.removeprefix("sha256:"))
        assert row is not None
        assert b"where I live" not in row.png


def _with_size(width: int, height: int) -> bytes:
    """A small file whose header states another size."""
    data = bytearray(png(4, 4))
    data[16:24] = struct.pack(">II", width, height)
    data[29:33] = struct.pack(">I", zlib.crc32(bytes(data[12:29])))
    return bytes(data)


@pytest.mark.parametrize(
    ("sent", "reported"),
    [
        ("%%%", "not valid base64"),
        (text(b"GIF89a"), "not a PNG file"),
        (text(b"\x89PNG\r\n\x1a\n"), "not a PNG file"),
        (text(png(513, 4)), "513 x 4 px"),
        (text(_with_size(100_000, 100_000)), "100000 x 100000 px"),
        (text(_with_size(0, 4)), "0 x 4 px"),
        (text(png(40, 40)[:60]), "damaged"),
        (text(_with_size(400, 400)), "damaged"),
        (text(png(4, 4) + b"\0" * MAX_BYTES), "the limit is"),
    ],
)
def test_other_files_are_refused_in_a_sentence(sqlite: Database, sent: str, reported: str) -> None:
    with sqlite.write() as session, pytest.raises(Invalid, match=reported) as refused:
        store_picture(session, sent)
    assert refused.value.field == "png"
