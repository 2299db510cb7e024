"""Whether a file is still the video: size, time of change, bytes."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from app.runs.task import _check_file
from app.storage.models import Video
from app.videos.same_file import is_same, is_untouched
from app.videos.table import pack, unpack
from tsr_engine.errors import InputError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.video_probe import video_sha256

TABLE = FrameTable(Fraction(1, 25), *(np.zeros(1, np.int64),) * 2, *(np.zeros(1, np.bool_),) * 2, 1, complete=True)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "drive.mp4"
    path.write_bytes(b"the bytes of a drive")
    return path


@pytest.fixture
def video(path: Path) -> Video:
    found = path.stat()
    frames = pack(TABLE, found.st_mtime_ns)
    return Video(id=video_sha256(path), path=str(path), size=found.st_size, frame_table=frames)


def test_a_file_that_nobody_touched_is_not_read(video: Video, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.videos.same_file.video_sha256", lambda path: pytest.fail(f"{path} is read"))
    assert is_untouched(video, path)
    assert is_same(video, path)


@pytest.mark.parametrize(
    ("content", "same"),
    [(b"the bytes of a drive", True), (b"other bytes, as many", False), (b"cut", False)],
)
def test_a_file_that_was_written_anew_is_known_by_its_bytes(
    content: bytes, same: bool, video: Video, path: Path
) -> None:
    path.write_bytes(content)
    os.utime(path, ns=(0, 10**18))
    assert not is_untouched(video, path)
    assert is_same(video, path) is same
    if same:
        _check_file(video)
    else:
        with pytest.raises(InputError, match="has changed since it was added"):
            _check_file(video)


def test_a_file_that_is_gone(video: Video, path: Path) -> None:
    path.unlink()
    assert not is_untouched(video, path)
    with pytest.raises(InputError, match="is not there any more"):
        _check_file(video)


@pytest.mark.parametrize("keep", [0, 9, 60, -4])
def test_a_damaged_table_is_a_sentence(video: Video, keep: int) -> None:
    assert unpack(video.frame_table) == TABLE
    with pytest.raises(InputError, match="frame table is damaged"):
        unpack(video.frame_table[:keep])
