"""Imports are recognised, unpacked and checked."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.small_datasets import make_dataset, make_track, make_video, target_of, tracks_of
from tsr_engine.errors import ImportFormatError, InputError, UsageError
from tsr_engine.exchange import load
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import Format, ImportTarget
from tsr_engine.exchange.load import detect_format, read_dataset
from tsr_engine.exchange.registry import FORMATS, complete_switches

TOOL_FORMATS = ["cvat-video", "cvat-images", "datumaro", "label-studio"]


@pytest.mark.parametrize("format", TOOL_FORMATS)
def test_each_format_is_recognised_as_file_folder_and_archive(tmp_path: Path, format: str) -> None:
    data = make_dataset()
    export_dataset(data, FORMATS[format], tmp_path / "out", zipped=False)
    export_dataset(data, FORMATS[format], tmp_path / "out.zip", zipped=True)
    with zipfile.ZipFile(tmp_path / "wrapped.zip", "w") as archive:
        for path in (tmp_path / "out").rglob("*"):
            archive.write(path, f"task 7/{path.relative_to(tmp_path / 'out')}")
    for name in ("out", "out.zip", "wrapped.zip"):
        assert sorted(tracks_of(read_dataset(tmp_path / name, target_of(data)))) == ["h3", "m1", "m2"]
    found = detect_format(tmp_path / "out")
    assert found is not None
    assert found[0].name == format


def test_unknown_formats_are_refused(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("Dear all")
    with pytest.raises(ImportFormatError, match=r"letter.txt: matches none of CVAT for video 1\.1, CVAT for images"):
        read_dataset(tmp_path / "letter.txt", target_of(make_dataset()))
    with pytest.raises(InputError, match="no file or folder"):
        read_dataset(tmp_path / "gone", target_of(make_dataset()))


def test_a_given_format_reports_its_own_error(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text("<html/>")
    with pytest.raises(ImportFormatError, match="outermost element is <html>"):
        read_dataset(tmp_path / "a.xml", target_of(make_dataset()), FORMATS["cvat-video"])


def test_options_apply_to_the_recognised_format(tmp_path: Path) -> None:
    export_dataset(make_dataset(), FORMATS["cvat-video"], tmp_path / "o.zip", zipped=True)
    assert read_dataset(tmp_path / "o.zip", target_of(make_dataset(), switches={"size": "scale"})).videos
    with pytest.raises(UsageError, match=r"no option 'link'.* taken for CVAT for video 1\.1.*name it with format="):
        read_dataset(tmp_path / "o.zip", target_of(make_dataset(), switches={"link": "iou"}))
    with pytest.raises(UsageError, match=r"no option 'link'; its options are: [a-z_, ]+\. Leave it out\.$"):
        read_dataset(tmp_path / "o.zip", target_of(make_dataset(), switches={"link": "iou"}), FORMATS["cvat-video"])


def test_a_text_option_takes_any_text_but_blank() -> None:
    found = complete_switches(FORMATS["label-studio"], {"task": "drive #2.mp4"}, reading=True)
    assert found["task"] == "drive #2.mp4"
    assert complete_switches(FORMATS["label-studio"], {}, reading=True)["task"] == "auto"
    with pytest.raises(UsageError, match="option task"):
        complete_switches(FORMATS["label-studio"], {"task": " "}, reading=True)


def test_switches_are_checked(tmp_path: Path) -> None:
    export_dataset(make_dataset(), FORMATS["cvat-video"], tmp_path / "o.zip", zipped=True)
    with pytest.raises(UsageError, match="size of CVAT for video 1.1 must be one of refuse, scale"):
        read_dataset(tmp_path / "o.zip", target_of(make_dataset(), switches={"size": "x"}))


def test_unpacked_files_are_removed(tmp_path: Path) -> None:
    export_dataset(make_dataset(), FORMATS["cvat-video"], tmp_path / "o.zip", zipped=True)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    read_dataset(tmp_path / "o.zip", target_of(make_dataset()), scratch=scratch)
    with zipfile.ZipFile(tmp_path / "bad.zip", "w") as archive:
        archive.writestr("annotations.xml", "<annotations><track/></annotations>")
        archive.writestr("../x", "y")
    with pytest.raises(ImportFormatError, match="leads out"):
        read_dataset(tmp_path / "bad.zip", target_of(make_dataset()), scratch=scratch)
    assert not list(scratch.iterdir())


@pytest.mark.parametrize(
    ("tracks", "rule"),
    [
        ([make_track("a"), make_track("a", range(50, 60))], "two tracks are called 'a'"),
        ([make_track("a", boxes=np.tile([-3.0, 0, 9, 9], (30, 1)))], "reaches out of the picture"),
        ([make_track("a", frames=range(90, 120))], "must be in 0 to 99"),
    ],
)
def test_invalid_data_from_a_reader_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tracks: list[object], rule: str
) -> None:
    def read(_path: Path, target: ImportTarget) -> Dataset:
        return Dataset(target.labels, (make_video(tracks),))  # type: ignore[arg-type]

    careless = Format("careless", "Careless", "", None, read, sniff=lambda path: path.suffix == ".c")
    monkeypatch.setattr(load, "FORMATS", {"careless": careless})
    (tmp_path / "f.c").write_text("x")
    with pytest.raises(ImportFormatError, match=rule):
        read_dataset(tmp_path / "f.c", target_of(make_dataset()))
    with pytest.raises(UsageError, match="written only"):
        read_dataset(tmp_path / "f.c", target_of(make_dataset()), replace(careless, read=None))


def _broken_files(folder: Path) -> Iterator[tuple[str, bytes]]:
    for name in TOOL_FORMATS:
        export_dataset(make_dataset(), FORMATS[name], folder / name, zipped=False)
        path = next(p for p in (folder / name).rglob("*") if p.suffix in (".xml", ".json") and "config" not in p.name)
        yield name, path.read_bytes()


def test_no_damage_ends_in_a_traceback(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    refused = 0
    for name, content in list(_broken_files(tmp_path)):
        for _ in range(40):
            damaged = bytearray(content)
            for _ in range(int(rng.integers(1, 4))):
                at = int(rng.integers(0, len(damaged)))
                kind = rng.integers(0, 3)
                if kind == 0:
                    damaged[at] = int(rng.integers(0, 256))
                elif kind == 1:
                    del damaged[at : at + int(rng.integers(1, 50))]
                else:
                    damaged[at:at] = damaged[:: max(1, len(damaged) // 40)]
            path = tmp_path / f"damaged{'.xml' if name.startswith('cvat') else '.json'}"
            path.write_bytes(bytes(damaged))
            try:
                read_dataset(path, target_of(make_dataset()), FORMATS[name])
            except ImportFormatError as error:
                refused += 1
                assert path.name in str(error)  # noqa: PT017
    assert refused > 20
