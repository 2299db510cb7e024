"""A file is recognised as the video by the kernel's data or by its bytes, never by its name alone."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Video
from app.videos.checked_file import ChangedError, CheckedFile, library_file
from app.videos.file_changes import confirm_content, require_unchanged
from app.videos.packed_table import pack, unpack
from tests.app.databases import put_tables
from tsr_engine.errors import InputError, VideoError
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import OpenedFile, stamp_of
from tsr_engine.io.video_probe import video_sha256

TABLE = FrameTable(Fraction(1, 25), *(np.zeros(1, np.int64),) * 2, *(np.zeros(1, np.bool_),) * 2, 1, complete=True)
CONTENT = b"the bytes of a drive"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "drive.mp4"
    path.write_bytes(CONTENT)
    return path


@pytest.fixture
def database(tmp_path: Path) -> Database:
    put_tables(tmp_path / "tsr.sqlite")
    return Database(f"sqlite:///{tmp_path / 'tsr.sqlite'}")


@pytest.fixture
def video(path: Path, database: Database) -> Video:
    row = Video(id=video_sha256(path), name="drive.mp4", path=str(path), size=len(CONTENT), frame_table=pack(TABLE))
    row.warnings, row.stamp = [], list(stamp_of(path.stat()))
    with database.write() as session:
        session.add(row)
    return row


@pytest.fixture
def file(video: Video, tmp_path: Path) -> CheckedFile:
    return library_file(Settings(home=tmp_path / "home", roots=()), video)


def stored_stamp(database: Database, video: Video) -> list[int] | None:
    with database.read() as session:
        return session.get_one(Video, video.id).stamp


def test_an_untouched_file_is_not_read(
    database: Database, file: CheckedFile, video: Video, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(OpenedFile, "sha256", lambda self: pytest.fail(f"{self} is read"))
    confirm_content(database, file, video)


@pytest.mark.parametrize(("content", "same"), [(CONTENT, True), (b"other bytes, as many", False), (b"cut", False)])
def test_a_rewritten_file_is_recognised_by_its_bytes(
    content: bytes, same: bool, database: Database, video: Video, file: CheckedFile, path: Path
) -> None:
    before = path.stat()
    path.write_bytes(content)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))  # restore its time
    if same:
        require_unchanged(database, file, video)
        assert stored_stamp(database, video) == list(stamp_of(path.stat())), "read once, not each time"
    else:
        with pytest.raises(ChangedError):
            confirm_content(database, file, video)
        with pytest.raises(InputError, match="has changed since it was added"):
            require_unchanged(database, file, video)
        assert stored_stamp(database, video) == video.stamp


def test_a_restored_copy_is_the_video(database: Database, video: Video, file: CheckedFile, path: Path) -> None:
    path.unlink()
    path.write_bytes(CONTENT)
    confirm_content(database, file, video)


def test_a_row_of_an_older_version_is_read_once(
    database: Database, video: Video, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    video.stamp = None
    confirm_content(database, library_file(Settings(home=tmp_path, roots=()), video), video)
    video.stamp = stored_stamp(database, video)
    monkeypatch.setattr(OpenedFile, "sha256", lambda self: pytest.fail(f"{self} is read"))
    confirm_content(database, library_file(Settings(home=tmp_path, roots=()), video), video)


def test_a_missing_file_is_reported(database: Database, video: Video, file: CheckedFile, path: Path) -> None:
    path.unlink()
    with pytest.raises(VideoError, match="There is no video at"):
        confirm_content(database, file, video)
    with pytest.raises(InputError, match="is missing"):
        require_unchanged(database, file, video)


@pytest.mark.parametrize("keep", [0, 9, 60, -4])
def test_a_damaged_table_is_reported(video: Video, keep: int) -> None:
    assert video.frame_table is not None
    assert unpack(video.frame_table) == TABLE
    with pytest.raises(InputError, match="frame table is damaged"):
        unpack(video.frame_table[:keep])
