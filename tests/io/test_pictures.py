"""Still pictures are read, or refused before they are decompressed."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from tsr_engine.errors import InputError
from tsr_engine.io.pictures import MAX_PIXELS, SUFFIXES, find_pictures, read_picture


def random_picture(height: int = 30, width: int = 40) -> np.ndarray:
    return np.random.default_rng(3).integers(0, 255, (height, width, 3), dtype=np.uint8)


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".ppm", ".tif", ".webp"])
def test_lossless_pictures_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    Image.fromarray(random_picture()[..., ::-1].copy()).save(path, **({"lossless": True} if suffix == ".webp" else {}))
    assert suffix in SUFFIXES
    np.testing.assert_array_equal(read_picture(path), random_picture())


def test_a_grey_picture_has_three_channels(tmp_path: Path) -> None:
    path = tmp_path / "a.pgm"
    cv2.imwrite(str(path), random_picture()[..., 0])
    np.testing.assert_array_equal(read_picture(path), np.repeat(random_picture()[..., :1], 3, axis=2))


def test_a_rotated_photo_is_turned_upright(tmp_path: Path) -> None:
    picture = Image.fromarray(np.zeros((20, 60, 3), np.uint8))
    exif = picture.getexif()
    exif[0x0112] = 6
    picture.save(tmp_path / "a.jpg", exif=exif)
    assert read_picture(tmp_path / "a.jpg").shape == (60, 20, 3)


def png_of(width: int, height: int) -> bytes:
    """A PNG of a few bytes with any announced size."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


def tiff_of(width: int, height: int) -> bytes:
    """A TIFF with one tag each for width and height."""
    tags = [(256, width), (257, height), (258, 8), (259, 1), (262, 1), (273, 8), (277, 1), (278, height), (279, 1)]
    directory = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    return b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(tags)) + directory + struct.pack("<I", 0)


def bmp_of(width: int, height: int) -> bytes:
    header = struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, 0, 0, 0, 0, 0)
    return b"BM" + struct.pack("<IHHI", 54, 0, 0, 54) + header


@pytest.mark.parametrize("make", [png_of, tiff_of, bmp_of])
@pytest.mark.parametrize(("width", "height"), [(10_001, 10_000), (30_000, 30_000)])
def test_a_decompression_bomb_is_refused_by_its_header(
    tmp_path: Path, make: object, width: int, height: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "bomb"
    path.write_bytes(make(width, height))  # type: ignore[operator]
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    with pytest.raises(InputError, match=f"more than the limit of {MAX_PIXELS} pixels"):
        read_picture(path)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is empty"),
        (b"not a picture at all", "is not a picture that can be read"),
        (png_of(40, 30), "is not a picture that can be read"),
        (b"\0\0\0\x20ftypisom" + bytes(100), "is a video, not a picture. Use `tsr track`"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, content: bytes, sentence: str) -> None:
    path = tmp_path / "a.jpg"
    path.write_bytes(content)
    with pytest.raises(InputError, match=sentence):
        read_picture(path)


def test_a_missing_picture_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Cannot read the picture"):
        read_picture(tmp_path / "none.png")
    with pytest.raises(InputError, match="There is no picture or folder"):
        list(find_pictures([tmp_path / "none.png"]))


def test_a_link_to_nothing_in_a_folder_is_refused_not_skipped(tmp_path: Path) -> None:
    (tmp_path / "a.png").symlink_to(tmp_path / "gone.png")
    (tmp_path / "folder.png").mkdir()
    (path,) = find_pictures([tmp_path])
    with pytest.raises(InputError, match=r"Cannot read the picture .*a\.png: No such file"):
        read_picture(path)


def test_a_folder_gives_its_pictures_in_order(tmp_path: Path) -> None:
    for name in ("b.png", "a.JPG", "note.txt"):
        (tmp_path / name).write_bytes(b"x")
    (tmp_path / "c.png").mkdir()
    assert [path.name for path in find_pictures([tmp_path])] == ["a.JPG", "b.png"]
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="has no pictures"):
        list(find_pictures([tmp_path / "empty"]))
