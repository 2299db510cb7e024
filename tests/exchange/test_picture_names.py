"""The grammar of picture names: the number that is the frame, or why there is none."""

from __future__ import annotations

import pytest

from tests.exchange.small_datasets import make_video
from tsr_engine.exchange.picture_names import PictureName, is_generic, parse_picture_name
from tsr_engine.exchange.video_spellings import VideoNameMatcher

OWN = VideoNameMatcher(make_video())
OLD = "0a1b2c3d4e5f60718293a4b5c6d7e8f3"
NEW = "q9XkT2vLbN7wYc41ZpD1"


def _name(base: str) -> PictureName:
    return parse_picture_name(base, OWN)


@pytest.mark.parametrize(
    ("base", "number", "stem"),
    [
        ("frame_000010", 10, ""),
        ("frame_000010.PNG", 10, ""),
        ("frame_000010.jpg.txt", 10, ""),
        ("drive_frame_000010.jpg", 10, "drive"),
        ("drive-aaaaaaaa_frame_000010.jpg", 10, "drive-aaaaaaaa"),
        ("000123.jpg", 123, ""),
        ("img00123.png", 123, ""),
        ("img_0001.jpg", 1, ""),
        ("frame0001.webp", 1, ""),
        ("frame-12.bmp", 12, ""),
        ("drive_1.txt", 1, "drive"),
        ("drive_00010.png", 10, "drive"),
        ("drive - 10.jpg", 10, "drive"),
        ("drive10.jpg", 10, "drive"),
        ("drive_img0010.jpg", 10, "drive"),
        ("x.mp4_10.jpg", 10, "x.mp4"),
        ("x_mp4_10.png", 10, "x_mp4"),
        ("x.mp4.10.png", 10, "x.mp4"),
        ("road52.xml", 52, "road"),
        (f"drive_mp4-0010_jpg.rf.{OLD}.txt", 10, "drive_mp4"),
        (f"drive-0010_jpeg.rf.{NEW}.jpg", 10, "drive"),
        (f"frame_000010_png.rf.{OLD}.jpg", 10, ""),
        (f"75_bmp.rf.{OLD}.jpg", 75, ""),
        ("1a2b3c4d-frame_000010.jpg", 10, ""),
        ("1a2b3c4d-drive_10.jpg", 10, "drive"),
        ("20240501-drive_10.jpg", 10, "20240501-drive"),
        ("b1c66a42-6f7d68ca-0000001.jpg", 1, "b1c66a42-6f7d68ca"),
        ("drive_640x360_10.jpg", 10, "drive_640x360"),
        ("2024-05-01_12-30-11_000010.jpg", 10, "2024-05-01_12-30-11"),
    ],
)
def test_prefixes_and_suffixes_are_recognised(base: str, number: int, stem: str) -> None:
    found = _name(base)
    assert (found.number, found.stem, found.seconds) == (number, stem, None)


NO_FRAME = {
    "has no frame number": ["", "picture.jpg", "frame.jpg"],
    "UUID": ["3f2504e0-4f89-11d3-9a0c-030512345678.jpg", f"0aad7d21-8091-4136-afa7-2a8f202d4901_jpg.rf.{OLD}.jpg"],
    "hash": [f"{OLD}.jpg", f"drive_{OLD}.jpg"],
    "no frame number": [
        "1a2b3c4d.jpg",
        "1714561811.jpg",
        "drive_640x360.jpg",
        "drive_1080p.jpg",
        "frame_-1.jpg",
        "-1.jpg",
        "frame_10 (1).jpg",
        "frame_10_cam0.jpg",
        "frame_1e3.jpg",
        "frame_\u0661\u0660.jpg",
    ],
    "date": [
        "20240501.jpg",
        "20240501_123011.jpg",
        "2024-05-01_12-30-11.jpg",
        "drive_2024-05-01 12.30.11.jpg",
        "PXL_20240501_123011123.jpg",
        "WhatsApp-Video-2025-03-17-at-15_03_46.jpg",
    ],
    "time of day": ["drive_12-30-11.jpg"],
    "decimals": ["1714561811.123456.jpg", "drive_0.4.jpg"],
    "decimal point": ["drive-mp4-t-0-4.jpg"],
    "name of the video": ["drive.mp4", "drive.jpg"],
}


@pytest.mark.parametrize(("base", "why"), [(base, why) for why, bases in NO_FRAME.items() for base in bases])
def test_digits_that_are_not_a_frame(base: str, why: str) -> None:
    found = _name(base)
    assert (found.number, found.seconds) == (None, None)
    assert why in found.reason


@pytest.mark.parametrize("base", ["drive.mp4#t=0.4", "drive.mp4#t=0.4.jpg", "drive.mp4%23t=0.4.txt"])
def test_times_of_vott(base: str) -> None:
    found = _name(base)
    assert (found.number, found.seconds, found.stem) == (None, 0.4, "drive.mp4")


def test_the_tool_is_recognised_by_the_name() -> None:
    assert _name(f"drive_mp4-0010_jpg.rf.{OLD}").roboflow
    assert _name(f"clip-0010_jpg.rf.{NEW}").roboflow
    assert _name("drive.mp4-0010.jpg").roboflow
    assert not _name(f"drive_10_jpg.rf.{OLD}").roboflow, "the name of an uploaded picture"
    assert not _name("drive-0010.jpg").roboflow


@pytest.mark.parametrize(
    ("base", "ambiguous"),
    [("frame_10_1.jpg", True), ("000030_10.png", True), ("20240501_123011_000123.jpg", True), ("drive_1.jpg", False)],
)
def test_two_numbers_in_a_single_name_are_ambiguous(base: str, ambiguous: bool) -> None:
    assert _name(base).ambiguous == ambiguous


def test_a_video_whose_name_is_a_number() -> None:
    own = VideoNameMatcher(make_video(name="000030.mp4"))
    assert not parse_picture_name("000030_10.png", own).ambiguous
    own = VideoNameMatcher(make_video(name="my_frame.mp4"))
    assert parse_picture_name("my_frame_10.png", own).stem == "my_frame"


def test_words_that_do_not_name_a_video() -> None:
    assert all(map(is_generic, ("frame", "IMG", "pictures")))
    assert not any(map(is_generic, ("drive", "drive_frame", "")))
