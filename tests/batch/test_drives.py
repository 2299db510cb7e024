"""Videos that inputs name, and the names of their output folders."""

from __future__ import annotations

from pathlib import Path

import pytest

from tsr_engine.batch.drives import find_drives, folder_names
from tsr_engine.errors import InputError


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    for name in ("a/drive.mp4", "a/notes.txt", "b/drive.MKV", "b/deep/x.avi", "b/.hidden/y.mp4"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return tmp_path


def names(found: list[Path], top: Path) -> list[str]:
    return [str(path.relative_to(top)) for path in found]


def test_files_folders_and_patterns_list_videos_once(archive: Path) -> None:
    found = find_drives([f"{archive}/b", f"{archive}/a/drive.mp4", f"{archive}/**/*.avi"])
    assert names(found, archive) == ["b/deep/x.avi", "b/drive.MKV", "a/drive.mp4"]


def test_annotated_videos_of_batches_are_no_drives(archive: Path) -> None:
    """The same command again must not track its own results."""
    for name in ("a/out/drive/seen.mp4", "a/out/drive/report.json", "b/seen.mp4"):
        (archive / name).parent.mkdir(parents=True, exist_ok=True)
        (archive / name).touch()
    for inputs in ([str(archive)], [f"{archive}/**/*.[maM]*"]):
        assert "b/seen.mp4" in (found := names(find_drives(inputs), archive))
        assert "a/out/drive/seen.mp4" not in found
    assert names(find_drives([f"{archive}/a/out/drive/seen.mp4"]), archive) == ["a/out/drive/seen.mp4"], "it is named"


def test_a_list_file_names_videos(archive: Path) -> None:
    listing = archive / "list.txt"
    listing.write_text(f"# archive\n\na/drive.mp4\n{archive}/b/drive.MKV\n", encoding="utf-8")
    assert names(find_drives([f"@{listing}"]), archive) == ["a/drive.mp4", "b/drive.MKV"]
    listing.write_text("a/drive.mp4\nnone.mp4\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"list\.txt, line 2: There is no video at"):
        find_drives([f"@{listing}"])
    listing.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="not UTF-8 text"):
        find_drives([f"@{listing}"])


@pytest.mark.parametrize(
    ("text", "reported"), [("a/none.mp4", "no video at"), ("*.mov", "No file matches"), ("a/empty", "has no video")]
)
def test_inputs_without_a_video_are_refused(archive: Path, text: str, reported: str) -> None:
    (archive / "a/empty").mkdir()
    with pytest.raises(InputError, match=reported):
        find_drives([f"{archive}/{text}"])


def test_folder_names_are_unique() -> None:
    paths = [Path("/x/Drive 1.mp4"), Path("/y/drive.mp4"), Path("/z/DRIVE.mkv"), Path("/x/...")]
    given = folder_names(paths, {})
    assert given[paths[0]] == "Drive-1"
    assert given[paths[1]].startswith("drive-")
    assert given[paths[2]].startswith("DRIVE-")
    assert given[paths[3]] == "drive" or given[paths[3]].startswith("drive-")
    assert len({name.casefold() for name in given.values()}) == 4
    later = folder_names([Path("/w/drive-1.mp4")], given)
    assert later[Path("/w/drive-1.mp4")].casefold() != "drive-1"
    assert {path: later[path] for path in paths} == given
