"""Exports into folders and archives contain the same files with the same hashes, and no partial ones."""

from __future__ import annotations

import errno
import gc
import hashlib
import io
import resource
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tsr_engine.exchange.archive import unpack
from tsr_engine.exchange.output_sink import FolderSink, OutputSink, ZipSink


def fill(out: OutputSink) -> None:
    """Write two files in turns, and small ones in between."""
    with out.text("a/rows.csv") as rows, out.text("b.txt", encoding="ascii", errors="replace") as other:
        for k in range(3000):
            rows.write(f"{k},ä\r\n")
            if not k % 1000:
                out.put(f"labels/{k}.txt", b"14 0.5 0.5 0.1 0.1\n" * k)
        other.write("ä\n")
    out.put("größe.jpg", b"\xff\xd8" * 500)


def break_off(out: OutputSink) -> None:
    with out.text("half.csv") as half:
        half.write("x" * 500_000)
        raise RuntimeError("stop")


def test_a_folder_and_an_archive_have_the_same_content(tmp_path: Path) -> None:
    folder, target = tmp_path / "out", io.BytesIO()
    folder.mkdir()
    plain = FolderSink(folder)
    fill(plain)
    with ZipSink(target, tmp_path) as packed:
        fill(packed)
    assert plain.files == packed.files
    with zipfile.ZipFile(target) as archive:
        assert archive.testzip() is None
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert {entry.external_attr >> 16 for entry in archive.infolist()} == {0o100644}
        for entry in plain.files:
            content = (folder / entry["name"]).read_bytes()
            assert archive.read(entry["name"]) == content
            assert (entry["size"], entry["sha256"]) == (len(content), hashlib.sha256(content).hexdigest())
    again = io.BytesIO()
    with ZipSink(again, tmp_path) as packed:
        fill(packed)
    assert again.getvalue() == target.getvalue()
    assert [path.name for path in tmp_path.iterdir()] == ["out"], "files that grow have no name"


def test_partial_files_are_removed(tmp_path: Path) -> None:
    target = io.BytesIO()
    with ZipSink(target, tmp_path) as out:
        with pytest.raises(RuntimeError, match="stop"):
            break_off(out)
        out.put("whole.txt", b"x")
        with pytest.raises(ValueError, match="written twice"):
            out.put("whole.txt", b"y")
    assert zipfile.ZipFile(target).namelist() == ["whole.txt"]
    assert [entry["name"] for entry in out.files] == ["whole.txt"]


def test_stopping_while_packing(tmp_path: Path) -> None:
    def stop() -> None:
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"), ZipSink(io.BytesIO(), tmp_path, stop) as out:
        out.put("big.bin", bytes(2 << 20))
    assert not list(tmp_path.iterdir())


def test_a_full_disk_is_reported_once(tmp_path: Path) -> None:
    """The first error is raised, and garbage collection does not write again."""

    class Full(io.BytesIO):
        def write(self, data: Any, /) -> int:
            if self.tell() + len(data) > 100_000:
                raise OSError(errno.ENOSPC, "No space left on device")
            return super().write(data)

    def write() -> None:
        with ZipSink(Full(), tmp_path) as out:
            for k in range(100):
                out.put(f"{k}.jpg", bytes(5_000))

    with pytest.raises(OSError, match="No space left"):
        write()
    gc.collect()


def test_a_short_write_is_an_error(tmp_path: Path) -> None:
    """The system writes as much as fits and returns the count."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    try:
        with pytest.raises(OSError, match="too large"):
            FolderSink(tmp_path).put("a.bin", bytes(150_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_an_export_unpacks_again(tmp_path: Path) -> None:
    path, folder = tmp_path / "a.zip", tmp_path / "back"
    folder.mkdir()
    with path.open("wb") as stream, ZipSink(stream, tmp_path) as out:
        fill(out)
    assert sorted(unpack(path, folder)) == [entry["name"] for entry in out.files]
