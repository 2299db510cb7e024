"""Kinds of video are recognised by their first bytes; similar files of other kinds are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tsr_engine.errors import VideoError
from tsr_engine.io.pictures import read_picture
from tsr_engine.io.video import open_video
from tsr_engine.io.video_kinds import MIN_HEAD_BYTES, cannot_be_video, kind_of

MakeVideo = Callable[[str], Any]


@pytest.mark.parametrize(
    ("made_as", "name"),
    [
        ("constant", "MP4"),
        ("avi_mjpeg", "AVI"),
        ("matroska_variable", "Matroska"),
        ("ts", "MPEG-TS"),
        ("m2ts", "MPEG-TS"),
        ("ps", "MPEG-PS"),
        ("flv", "FLV"),
        ("wmv", "WMV"),
        ("raw_h264", "H.264"),
        ("raw_hevc", "HEVC"),
        ("gif", "GIF"),
        ("apng", "APNG"),
        ("webp", "WebP"),
    ],
)
def test_every_kind_is_recognised_by_its_first_bytes(make_video: MakeVideo, made_as: str, name: str) -> None:
    content = make_video(made_as).path.read_bytes()
    kind = kind_of(content[:MIN_HEAD_BYTES])
    assert kind is not None
    assert kind.name == name
    assert not cannot_be_video(content[:MIN_HEAD_BYTES])


@pytest.mark.parametrize(
    "head",
    [
        b"G" * 5000,  # letters, not packets
        (b"G" + bytes(187)) * 3 + bytes(3000),  # three sync bytes are chance
        b"\0\0\1\0\1\0\x10\x10" + bytes(100),  # an icon
        b"\0\0\1\xb3" + bytes(100),  # MPEG video without a container
        b"\0\0\1\xba\xff" + bytes(100),
        b"\0\0\0\1\x67\x64\0\x1f\0\0\1\xff\xff",  # a forbidden bit behind a good start
        b"FLV\x02" + bytes(100),
        b"GIF90a" + bytes(100),
        b"RIFF\0\0\0\0WEBPVP8 " + bytes(100),
        b"RIFF\0\0\0\0WEBPVP8X" + bytes(100),
        b"\x30\x26\xb2\x75" + bytes(100),
        b"#EXTM3U\n" + b"x" * 5000,
        b"ffconcat version 1.0\n",
        b"<?xml version='1.0'?><MPD/>",
        b"",
    ],
)
def test_other_files_are_not_recognised(head: bytes) -> None:
    assert kind_of(head) is None


@pytest.mark.parametrize("name", ["PNG", "JPEG", "WebP"])
def test_a_single_picture_is_reported_as_one(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"x.{name.lower()}"
    cv2.imwrite(str(path), np.zeros((20, 30, 3), np.uint8))
    with pytest.raises(VideoError, match=rf"is not a video but a single picture \({name}\). Use `tsr detect`"):
        open_video(path)
    assert read_picture(path).shape == (20, 30, 3)


@pytest.mark.parametrize("name", ["apng", "webp"])
def test_an_animation_is_not_a_single_picture(make_video: MakeVideo, name: str) -> None:
    from tsr_engine.errors import InputError

    with pytest.raises(InputError, match="is a video, not a picture. Use `tsr track`"):
        read_picture(make_video(name).path)


@pytest.mark.parametrize("keep", [40, 400])
def test_a_truncated_webp_is_refused(make_video: MakeVideo, tmp_path: Path, keep: int) -> None:
    path = tmp_path / "cut.webp"
    path.write_bytes(make_video("webp").path.read_bytes()[:keep])
    with pytest.raises(VideoError, match="it is damaged or cut short, or not WebP though it begins like that"):
        open_video(path)


def test_a_huge_webp_is_refused_by_its_header(make_video: MakeVideo, tmp_path: Path) -> None:
    content = bytearray(make_video("webp").path.read_bytes())
    content[24:30] = b"\x7f\x3e\0" * 2
    path = tmp_path / "huge.webp"
    path.write_bytes(content)
    with pytest.raises(VideoError, match="16000x16000, more than the limit"):
        open_video(path)
