"""Files of an export, into a folder and into an archive: the same files with the same hashes, and nothing half."""

from __future__ import annotations

import hashlib
import io
import struct
import zipfile
from pathlib import Path

import pytest

from tsr_engine.exchange import zip_writer
from tsr_engine.exchange.archive import unpack
from tsr_engine.exchange.outlet import FolderOutlet, Outlet, ZipOutlet
from tsr_engine.exchange.zip_writer import ZipWriter


def fill(out: Outlet) -> None:
    """Two files that grow side by side, and small ones in between."""
    with out.text("a/rows.csv") as rows, out.text("b.txt", encoding="ascii", errors="replace") as other:
        for k in range(3000):
            rows.write(f"{k},ä\r\n")
            if not k % 1000:
                out.put(f"labels/{k}.txt", b"14 0.5 0.5 0.1 0.1\n" * k)
        other.write("ä\n")
    out.put("größe.jpg", b"\xff\xd8" * 500)


def break_off(out: Outlet) -> None:
    """A writer that fails in the middle of a file."""
    with out.text("half.csv") as half:
        half.write("x" * 500_000)
        raise RuntimeError("stop")


def test_a_folder_and_an_archive_hold_the_same(tmp_path: Path) -> None:
    folder, target = tmp_path / "out", io.BytesIO()
    folder.mkdir()
    plain = FolderOutlet(folder)
    fill(plain)
    with ZipOutlet(target, tmp_path) as packed:
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
    with ZipOutlet(again, tmp_path) as packed:
        fill(packed)
    assert again.getvalue() == target.getvalue()
    assert [path.name for path in tmp_path.iterdir()] == ["out"], "files that grow have no name"


def test_a_file_that_broke_off_is_not_there(tmp_path: Path) -> None:
    target = io.BytesIO()
    with ZipOutlet(target, tmp_path) as out:
        with pytest.raises(RuntimeError, match="stop"):
            break_off(out)
        out.put("whole.txt", b"x")
        with pytest.raises(ValueError, match="written twice"):
            out.put("whole.txt", b"y")
    assert zipfile.ZipFile(target).namelist() == ["whole.txt"]
    assert [entry["name"] for entry in out.files] == ["whole.txt"]


def test_stopping_while_it_is_packed(tmp_path: Path) -> None:
    def stop() -> None:
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"), ZipOutlet(io.BytesIO(), tmp_path, stop) as out:
        out.put("big.bin", bytes(2 << 20))
    assert not list(tmp_path.iterdir())


def test_more_entries_than_an_old_archive_can_count(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(zip_writer, "_TOP16", 40)
    path, folder = tmp_path / "many.zip", tmp_path / "back"
    folder.mkdir()
    with path.open("wb") as stream:
        archive = ZipWriter(stream)
        for k in range(50):
            archive.put(f"{k}", bytes([k]))
        archive.close()
    with zipfile.ZipFile(path) as found:
        assert len(found.namelist()) == 50
        assert found.read("49") == bytes([49])
    assert len(unpack(path, folder)) == 50


def test_sizes_beyond_four_gigabytes_have_their_place(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """With the limit set low: what stands in the wide fields, before the data and in the list of entries."""
    monkeypatch.setattr(zip_writer, "_TOP32", 100)
    monkeypatch.setattr(zip_writer, "_CHUNK", 16)
    target = io.BytesIO()
    archive = ZipWriter(target)
    content = bytes(range(250)) * 2
    archive.take("wide.jpg", io.BytesIO(content), len(content))
    archive.close()
    raw = target.getvalue()
    begin = 30 + len("wide.jpg")
    assert struct.unpack_from("<2L", raw, 18) == (100, 100), "the narrow fields say: look at the wide ones"
    assert struct.unpack_from("<2H2Q", raw, begin) == (1, 16, 500, 500)
    assert raw[begin + 20 : begin + 520] == content
    listed = raw.index(b"PK\x01\x02")
    assert struct.unpack_from("<2H2Q", raw, listed + 46 + len("wide.jpg")) == (1, 16, 500, 500)
    wide = raw.index(b"PK\x06\x06")
    assert struct.unpack_from("<3Q", raw, wide + 32) == (1, wide - listed, listed)


def test_what_is_written_is_unpacked_again(tmp_path: Path) -> None:
    path, folder = tmp_path / "a.zip", tmp_path / "back"
    folder.mkdir()
    with path.open("wb") as stream, ZipOutlet(stream, tmp_path) as out:
        fill(out)
    assert sorted(unpack(path, folder)) == [entry["name"] for entry in out.files]
