"""ZIP files that escape their folder, unpack without end, or hide something."""

from __future__ import annotations

import io
import stat
import struct
import tracemalloc
import zipfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from tests.invalid_archives import ARCHIVE_FAULTS, archive_of_empty_files
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.archive import ArchiveLimits, pack, unpack
from tsr_engine.exchange.untrusted_zip import entry_names, is_archive


def _zip(path: Path, *entries: tuple[str | zipfile.ZipInfo, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return path


def _refused(archive: Path, folder: Path, limits: ArchiveLimits | None = None) -> str:
    folder.mkdir()
    with pytest.raises(ImportFormatError) as caught:
        unpack(archive, folder, limits=limits)
    assert archive.name in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("../evil.txt", "leads out"),
        ("a/../../evil.txt", "leads out"),
        ("/etc/evil", "absolute"),
        ("C:/evil", "absolute"),
        ("..\\evil", "absolute"),
        ("a\nb.txt", "control characters"),
        ("x/" * 40 + "a", "too long"),
        ("a" * 300, "too long"),
        ("inner.zip", "archive within"),
        ("deep/inner.tar.gz", "archive within"),
    ],
)
def test_unsafe_names_are_refused(tmp_path: Path, name: str, rule: str) -> None:
    said = _refused(_zip(tmp_path / "bad.zip", ("ok.txt", b"1"), (name, b"2")), tmp_path / "out")
    assert rule in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.zip", "out"]
    assert not list((tmp_path / "out").iterdir())


def test_a_name_with_a_nul_is_refused(tmp_path: Path) -> None:
    path = _zip(tmp_path / "nul.zip", ("a.xmlX.exe", b"1"))
    path.write_bytes(path.read_bytes().replace(b"a.xmlX.exe", b"a.xml\0.exe"))
    assert "control characters" in _refused(path, tmp_path / "out")


def test_links_are_refused(tmp_path: Path) -> None:
    link = zipfile.ZipInfo("annotations.xml")
    link.create_system = 3
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    assert "link" in _refused(_zip(tmp_path / "link.zip", (link, b"/etc/passwd")), tmp_path / "out")


def test_encrypted_entries_are_refused(tmp_path: Path) -> None:
    path = _zip(tmp_path / "locked.zip", ("a.txt", b"secret"))
    content = bytearray(path.read_bytes())
    at = content.rfind(b"PK\x01\x02")
    content[at + 8] |= 1
    path.write_bytes(bytes(content))
    assert "encrypted" in _refused(path, tmp_path / "out")


@pytest.mark.parametrize("second", ["a.txt", "A.TXT", "./a.txt"])
def test_duplicate_names_are_refused(tmp_path: Path, second: str) -> None:
    with pytest.warns(UserWarning, match="Duplicate") if second == "a.txt" else nullcontext():
        path = _zip(tmp_path / "twice.zip", ("a.txt", b"1"), (second, b"2"))
    assert "twice" in _refused(path, tmp_path / "out")


def test_a_name_of_both_file_and_folder_is_refused(tmp_path: Path) -> None:
    assert "at once" in _refused(_zip(tmp_path / "both.zip", ("a", b"1"), ("a/b", b"2")), tmp_path / "out")


def test_an_archive_with_another_suffix(tmp_path: Path) -> None:
    inner = io.BytesIO()
    with zipfile.ZipFile(inner, "w") as archive:
        archive.writestr("x", "y")
    path = _zip(tmp_path / "outer.zip", ("annotations.xml", inner.getvalue()))
    assert "archive within" in _refused(path, tmp_path / "out")


def test_a_bomb_by_ratio(tmp_path: Path) -> None:
    path = _zip(tmp_path / "bomb.zip", ("a.xml", b"0" * (8 << 20)))
    assert "times its packed size" in _refused(path, tmp_path / "out")
    assert sum(file.stat().st_size for file in (tmp_path / "out").rglob("*")) <= 3 << 20


def test_a_bomb_by_size_is_stopped_while_unpacking(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).bytes(3 << 20)
    path = _zip(tmp_path / "big.zip", ("a.bin", noise), ("b.bin", noise))
    assert "more than" in _refused(path, tmp_path / "one", ArchiveLimits(single=2 << 20))
    assert "brings the archive" in _refused(path, tmp_path / "two", ArchiveLimits(total=4 << 20))


def test_wrong_sizes_are_refused(tmp_path: Path) -> None:
    path = _zip(tmp_path / "lie.zip", ("a.txt", b"x" * 5000))
    content = bytearray(path.read_bytes())
    struct.pack_into("<I", content, content.rfind(b"PK\x01\x02") + 24, 10)
    path.write_bytes(bytes(content))
    assert "damaged" in _refused(path, tmp_path / "out")


def test_too_many_entries_are_refused(tmp_path: Path) -> None:
    path = _zip(tmp_path / "many.zip", *((f"{k}.txt", b"") for k in range(20)))
    assert "20 entries" in _refused(path, tmp_path / "out", ArchiveLimits(entries=10))
    assert "bytes" in _refused(path, tmp_path / "again", ArchiveLimits(directory=100))


@pytest.mark.parametrize(("at", "value"), [(8, b"\1\0\1\0"), (12, b"\x40\0\0\0")], ids=["entries", "bytes"])
def test_a_directory_longer_than_stated_is_refused(tmp_path: Path, at: int, value: bytes) -> None:
    """Long directories have a second record of the size, which zipfile believes."""
    path = _zip(tmp_path / "liar.zip", *((f"{k}.txt", b"") for k in range(20)))
    content = path.read_bytes()
    place = content.rfind(b"PK\5\6")
    end = bytearray(content[place:])
    size, begin = struct.unpack_from("<II", end, 12)
    end[at : at + len(value)] = value
    wide = struct.pack("<4sQHHIIQQQQ", b"PK\6\6", 44, 45, 45, 0, 0, 20, 20, size, begin)
    locator = struct.pack("<4sIQI", b"PK\6\7", 0, place, 1)
    path.write_bytes(content[:place] + wide + locator + bytes(end))
    assert "20 entries" in _refused(path, tmp_path / "out", ArchiveLimits(entries=10))
    assert "bytes" in _refused(path, tmp_path / "again", ArchiveLimits(directory=size - 1))
    (tmp_path / "whole").mkdir()
    assert len(unpack(path, tmp_path / "whole", limits=ArchiveLimits(entries=20, directory=size))) == 20


def test_a_directory_over_the_limit_is_not_parsed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "long.zip"
    path.write_bytes(archive_of_empty_files(ArchiveLimits().entries + 1))
    monkeypatch.setattr(zipfile, "ZipInfo", None)  # parsing an entry needs it
    with pytest.raises(ImportFormatError, match="400001 entries"):
        entry_names(path)


def test_an_endless_directory_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "sparse.zip"
    with path.open("wb") as file:
        file.truncate(1 << 30)  # zeros in a sparse file
        file.seek(0, 2)
        file.write(struct.pack("<4sHHHHIIH", b"PK\5\6", 0, 0, 1, 1, 1 << 30, 0, 0))
    tracemalloc.start()
    try:
        assert f"{1 << 30} bytes" in _refused(path, tmp_path / "out")
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("name", ARCHIVE_FAULTS)
def test_errors_of_zipfile_are_reported_as_damage(tmp_path: Path, name: str) -> None:
    path = _zip(tmp_path / "odd.zip", ("a.txt", b"1"))
    path.write_bytes(ARCHIVE_FAULTS[name](path.read_bytes()))
    assert is_archive(path)
    assert "damaged" in _refused(path, tmp_path / "out")
    with pytest.raises(ImportFormatError, match="damaged"):
        entry_names(path)


@pytest.mark.parametrize("keep", [0.3, 0.9])
def test_a_truncated_archive_is_refused(tmp_path: Path, keep: float) -> None:
    path = _zip(tmp_path / "cut.zip", *((f"{k}.txt", bytes(range(256)) * 8) for k in range(5)))
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * keep)])
    assert "ZIP archive" in _refused(path, tmp_path / "out")


def test_a_flipped_byte_is_refused(tmp_path: Path) -> None:
    path = _zip(tmp_path / "flip.zip", ("a.txt", bytes(range(256)) * 8))
    content = bytearray(path.read_bytes())
    content[60] ^= 0xFF
    path.write_bytes(bytes(content))
    assert "damaged" in _refused(path, tmp_path / "out")


def test_a_valid_archive_is_unpacked(tmp_path: Path) -> None:
    path = _zip(
        tmp_path / "good.zip",
        ("annotations.xml", b"<a/>"),
        ("images/frame_000001.jpg", b"jpeg"),
        ("__MACOSX/._annotations.xml", b"rubbish"),
        (".DS_Store", b"rubbish"),
    )
    (tmp_path / "all").mkdir()
    (tmp_path / "some").mkdir()
    assert sorted(unpack(path, tmp_path / "all")) == ["annotations.xml", "images/frame_000001.jpg"]
    assert unpack(path, tmp_path / "some", pictures=False) == ["annotations.xml"]
    assert (tmp_path / "some" / "annotations.xml").read_bytes() == b"<a/>"


def test_the_same_files_give_the_same_bytes(tmp_path: Path) -> None:
    packed = []
    for order in (("b.txt", "a/c.txt"), ("a/c.txt", "b.txt")):
        folder = tmp_path / order[0].replace("/", "-")
        (folder / "a").mkdir(parents=True)
        for name in order:
            (folder / name).write_text(name)
        out = io.BytesIO()
        pack(folder, out)
        packed.append(out.getvalue())
    assert packed[0] == packed[1]
    assert zipfile.ZipFile(io.BytesIO(packed[0])).namelist() == ["a/c.txt", "b.txt"]
