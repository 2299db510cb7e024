"""Spellings of a video's name."""

from __future__ import annotations

import unicodedata

import pytest

from tests.exchange.small_datasets import make_video
from tsr_engine.exchange.video_spellings import VideoNameMatcher


@pytest.mark.parametrize(
    ("video", "name"),
    [
        ("drive.mp4", "drive"),
        ("drive.mp4", "Drive.MP4"),
        ("drive.mp4", "drive_mp4"),
        ("drive.mp4", "1a2b3c4d-drive"),
        ("drive.mp4", "drive-aaaaaaaa"),
        ("My Drive (2).mov", "my_drive_2_mov"),
        ("My Drive (2).mov", "My%20Drive%20(2)"),
        ("100% drive #1 ü.mp4", "100_drive_1_ü"),
        ("Straße ü.mp4", unicodedata.normalize("NFD", "strasse_ü")),
        ("WhatsApp Video 2025-03-17 at 15.03.46.mp4", "WhatsApp-Video-2025-03-17-at-15_03_46_mp4"),
        ("1a2b3c4d-drive.mp4", "drive"),
    ],
)
def test_spellings_of_the_videos_name(video: str, name: str) -> None:
    assert VideoNameMatcher(make_video(name=video))(name)


@pytest.mark.parametrize(
    ("video", "name"),
    [
        ("drive.mp4", ""),
        ("drive.mp4", "other"),
        ("drive.mp4", "drive2"),
        ("drive.mp4", "my-drive"),
        ("drive.mp4", "rear_drive.mp4"),
        ("drive.mp4", "20240501-drive"),
        ("drive.mp4", "drive-bbbbbbbb"),
        ("drive1.mp4", "drive_1"),
    ],
)
def test_names_of_other_videos(video: str, name: str) -> None:
    assert not VideoNameMatcher(make_video(name=video))(name)
