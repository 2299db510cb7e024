"""Outputs of two processes at once, of a killed process, and their order of reaching the disk."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsr_engine.errors import StorageError
from tsr_engine.io.atomic import atomic_bytes, atomic_text
from tsr_engine.io.unfinished import UnfinishedFile, create_locked_folder, remove_leftovers
from tsr_engine.io.video import open_video
from tsr_engine.io.video_writer import VideoWriter


def test_two_writers_of_one_file_do_not_interfere(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    with atomic_text(path) as first:
        first.write("first " * 5000)
        with atomic_text(path) as second:
            second.write("second " * 9000)
        assert path.read_text() == "second " * 9000
        first.write("end")
    assert path.read_text() == "first " * 5000 + "end"
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.csv"]


def test_two_writers_of_one_video_do_not_interfere(tmp_path: Path) -> None:
    path = tmp_path / "out.mp4"
    grey = np.full((64, 96, 3), 128, np.uint8)
    with VideoWriter(path, 96, 64, Fraction(25)) as first:
        first.write(grey)
        with VideoWriter(path, 96, 64, Fraction(25)) as second:
            for _ in range(7):
                second.write(grey)
        with open_video(path) as video:
            assert len(list(video.frames())) == 7
        first.write(grey)
    with open_video(path) as video:
        assert len(list(video.frames())) == 2
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.mp4"]


def test_leftovers_of_a_killed_writer_are_removed(tmp_path: Path) -> None:
    path = tmp_path / "out[1].csv"
    script = (
        "import os, signal, sys\nfrom pathlib import Path\nfrom tsr_engine.io.atomic import atomic_text\n"
        "with atomic_text(Path(sys.argv[1])) as out:\n"
        "    out.write('half')\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    killed = subprocess.run([sys.executable, "-c", script, str(path)], check=False)
    assert killed.returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    mine = tmp_path / ".out[1].csv.holiday.part"
    mine.write_text("somebody else's")
    with atomic_text(path) as out:
        assert not left.exists()
        out.write("whole")
        assert remove_leftovers(path) == [], "what is being written stays"
    assert path.read_text() == "whole"
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [mine.name, path.name]


def test_names_may_be_as_long_as_a_folder_can_hold(tmp_path: Path) -> None:
    path = tmp_path / ("ü" * 125 + ".json")
    assert len(os.fsencode(path.name)) == 255
    left, lock = create_locked_folder(path)
    os.close(lock)
    with atomic_text(path) as out:
        assert not left.exists(), "leftovers of this output are known by their names"
        out.write("whole")
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    with pytest.raises(StorageError, match="File name too long"), atomic_text(tmp_path / f"x{path.name}"):
        pytest.fail("a name that is too long is refused before the work")


@pytest.fixture
def steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of files that were synced or renamed, in order."""
    reported: list[str] = []
    fsync, replace = os.fsync, Path.replace

    def watched_fsync(handle: int) -> None:
        fsync(handle)
        reported.append("folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else "file")

    def watched_replace(path: Path, target: Path) -> Path:
        reported.append("name")
        return replace(path, target)

    monkeypatch.setattr(os, "fsync", watched_fsync)
    monkeypatch.setattr(Path, "replace", watched_replace)
    return reported


def test_content_name_and_folder_are_synced_in_this_order(tmp_path: Path, steps: list[str]) -> None:
    with atomic_bytes(tmp_path / "a.bin") as out:
        out.write(b"x")
    assert steps == ["file", "name", "folder"]
    steps.clear()
    with VideoWriter(tmp_path / "v.mp4", 96, 64, Fraction(25)) as writer:
        writer.write(np.zeros((64, 96, 3), np.uint8))
    assert steps == ["file", "name", "folder"]


@pytest.mark.parametrize(("code", "works"), [(errno.EINVAL, True), (errno.EIO, False)])
def test_a_system_that_cannot_sync_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int, works: bool
) -> None:
    fsync = os.fsync

    def answer(handle: int) -> None:
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise OSError(code, os.strerror(code))
        fsync(handle)

    monkeypatch.setattr(os, "fsync", answer)

    def write() -> None:
        with atomic_text(tmp_path / "out.txt") as out:
            out.write("x")

    if works:
        write()
        assert (tmp_path / "out.txt").read_text() == "x"
    else:
        with pytest.raises(StorageError, match="Input/output error"):
            write()


def test_a_system_without_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are written; leftovers are kept, since their owner may be alive."""

    def refuse(*_: Any) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("tsr_engine.io.unfinished.fcntl.flock", refuse)
    left = tmp_path / ".out.txt.0123456789abcdef.part"
    left.write_text("half")
    with atomic_text(tmp_path / "out.txt") as out:
        out.write("x")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [left.name, "out.txt"]


def test_a_file_is_committed_once(tmp_path: Path) -> None:
    part = UnfinishedFile(tmp_path / "a")
    part.commit()
    part.drop()
    with pytest.raises(ValueError, match="committed once"):
        part.commit()
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]
