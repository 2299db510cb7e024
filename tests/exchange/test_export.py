"""An export is complete or absent: refusals, replacement, failures, kills, and two at once."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import signal
import subprocess
import sys
import zipfile
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.exchange.small_datasets import GTSRB, make_dataset, make_track, make_video
from tsr_engine.errors import ExportError, ImportFormatError, StorageError, UsageError
from tsr_engine.exchange import publish
from tsr_engine.exchange.dataset import Dataset, Skipped
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.manifest import MANIFEST, read_manifest
from tsr_engine.exchange.registry import FORMATS, complete_switches, format_named
from tsr_engine.exchange.split import make_split
from tsr_engine.io.unfinished import remove_leftovers

VIDEO = FORMATS["cvat-video"]


def test_at_every_step_the_old_or_the_new_export_is_complete(tmp_path: Path) -> None:
    script = Path(__file__).parent / "export_killer.py"
    command = [sys.executable, str(script), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    for name, report in json.loads(done.stdout).items():
        if name.endswith("moments"):
            # On a busy machine the last kills may come too late; each earlier one kept the old export.
            assert report["killed"] >= 2, report
            continue
        assert report["old"] >= (10 if name.startswith("folder") else 5), name
        assert report["new"] >= 1
        if name.endswith("kill"):
            assert set(report["codes"]) == {0, -signal.SIGKILL}
            # The test is meaningful only if kills leave files to remove.
            assert report["rubbish"] >= (10 if name.startswith("folder") else 4), name
        else:
            assert set(report["codes"]) == {0, 7}


def test_files_of_a_running_export_are_kept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    held, left = tmp_path / ".out.aaaa.part", tmp_path / ".out.bbbb.part"
    other = tmp_path / ".out2.cccc.part"
    for folder in (held, left, other):
        folder.mkdir()
        (folder / "half").write_text("x")
    handle = os.open(held, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        export_dataset(make_dataset(), VIDEO, out, zipped=False)
    finally:
        os.close(handle)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".out.aaaa.part", ".out2.cccc.part", "out"]
    remove_leftovers(out)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".out2.cccc.part", "out"]


def test_a_file_system_without_exchange(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publish.ctypes, "CDLL", lambda *_, **__: object())
    for name in ("old", "new"):
        export_dataset(make_dataset(make_track(name)), VIDEO, tmp_path / "out", zipped=False)
        assert f">{name}<" in (tmp_path / "out" / "annotations.xml").read_text()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_other_folders_are_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "holiday.jpg").write_bytes(b"x")
    with pytest.raises(StorageError, match="is not an earlier export"):
        export_dataset(make_dataset(), VIDEO, tmp_path / "photos", zipped=False)
    with pytest.raises(StorageError, match="is a folder"):
        export_dataset(make_dataset(), VIDEO, tmp_path / "photos", zipped=True)
    (tmp_path / "file").write_text("x")
    with pytest.raises(StorageError, match="is a file"):
        export_dataset(make_dataset(), VIDEO, tmp_path / "file", zipped=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "photos"]
    (tmp_path / "empty").mkdir()
    export_dataset(make_dataset(), VIDEO, tmp_path / "empty", zipped=False)


def test_stopping_leaves_nothing(tmp_path: Path) -> None:
    class Stop(Exception):
        pass

    def progress(done: int, of: int) -> None:
        assert 0 <= done <= of
        if done == 2:
            raise Stop

    with pytest.raises(Stop):
        export_dataset(make_dataset(), VIDEO, tmp_path / "out", ExportOptions(progress=progress), zipped=True)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("data", "rule"),
    [
        (make_dataset(make_track("a"), make_track("a", range(50, 60))), "two tracks are called 'a'"),
        (make_dataset(make_track(boxes=np.full((30, 4), np.nan))), "must be finite"),
        (make_dataset(make_track(frames=range(90, 120))), "must be in 0 to 99"),
    ],
)
def test_invalid_data_is_not_exported(tmp_path: Path, data: Dataset, rule: str) -> None:
    with pytest.raises(ExportError, match=rule):
        export_dataset(data, VIDEO, tmp_path / "out", zipped=False)
    assert not list(tmp_path.iterdir())


def test_unknown_options_are_refused(tmp_path: Path) -> None:
    for switches, rule in (({"rows": "some"}, "must be one of all, keys"), ({"colour": "red"}, "no option 'colour'")):
        with pytest.raises(UsageError, match=rule):
            export_dataset(make_dataset(), VIDEO, tmp_path / "out", ExportOptions(switches=switches), zipped=False)
    with pytest.raises(UsageError, match=r"no format 'cvat'\. Choose one of cvat-video"):
        format_named("cvat")
    with pytest.raises(ExportError, match="can only be imported"):
        export_dataset(make_dataset(), replace(VIDEO, write=None), tmp_path / "out", zipped=False)
    with pytest.raises(ExportError, match="consists of pictures"):
        export_dataset(make_dataset(), replace(VIDEO, needs_pictures=True), tmp_path / "out", zipped=False)
    assert complete_switches(VIDEO, {}, reading=False)["rows"] == "all"
    assert not list(tmp_path.iterdir())


def test_a_leaking_split_is_refused(tmp_path: Path) -> None:
    data = make_dataset(make_track("m1"), make_track("m2"))
    leaking = ExportOptions(split={("a" * 64, "m1"): "train", ("a" * 64, "m2"): "val"})
    with pytest.raises(ExportError, match="frame 10 would be in"):
        export_dataset(data, VIDEO, tmp_path / "out", leaking, zipped=False)
    assert not list(tmp_path.iterdir())


def test_content_of_the_manifest(tmp_path: Path) -> None:
    first, second = make_track("m1", range(10, 14)), make_track("m2", range(20, 22), label=-1)
    late = make_track("m3", range(50, 55), label=1, boxes=np.tile([600.0, 10, 700, 50], (5, 1)))
    video = make_video([first, second, late], rate=Fraction(30000, 1001), provenance={"run": "r1", "edits": 7})
    video = replace(video, pixel_ratio=Fraction(4, 3))
    data = Dataset(GTSRB, (video,), (Skipped("1 track", "rejected"),), ("repaired before",))
    split = make_split(data, {"train": 0.5, "val": 0.5}, 11)
    reported = export_dataset(
        data, VIDEO, tmp_path / "out", ExportOptions(split=split), zipped=False, about={"states": ["open"]}
    )
    content: dict[str, Any] = json.loads((tmp_path / "out" / MANIFEST).read_text())
    assert content == reported.content == read_manifest(tmp_path / "out").content
    assert content["tool"]["name"] == "tsr"
    assert content["videos"][0]["pixel_ratio"] == "4/3"
    assert content["videos"][0]["width"] == video.width, "boxes stay in stored pixels"
    assert content["format"]["name"] == "cvat-video"
    assert content["format"]["switches"] == {"rows": "all", "image": "png"}
    assert content["format"]["origin"] == 0
    assert content["classes"][14] == {"id": 14, "key": "stop", "name": "stop"}
    assert content["label_set"] == {"key": GTSRB.key, "name": GTSRB.name, "version": 1}
    assert (content["split"]["rule"], content["split"]["seed"]) == ("sign", 11)
    assert {tuple(row) for row in content["split"]["tracks"]} == {(*key, side) for key, side in split.items()}
    assert content["skipped"] == [{"what": "1 track", "reason": "rejected"}]
    assert content["repaired"] == [
        "repaired before",
        "Boxes that reached over the edge of the picture were cut there: 5.",
    ]
    assert content["asked"] == {"states": ["open"]}
    shown = content["videos"][0]
    assert shown["rate"] == "30000/1001"
    assert shown["sha256"] == "a" * 64
    assert shown["provenance"] == {"run": "r1", "edits": 7}
    assert shown["frame_table"]["frame"] == [10, 11, 12, 13, 20, 21, 50, 51, 52, 53, 54]
    assert shown["frame_table"]["time_ms"][:2] == [400.0, 440.0]
    counts = content["counts"]
    assert (counts["videos"], counts["tracks"], counts["boxes"]) == (1, 3, 11)
    by_class = {name: entry for side in counts["classes"].values() for name, entry in side.items()}
    assert by_class["stop"] == {"tracks": 1, "boxes": 4}
    assert by_class[""] == {"tracks": 1, "boxes": 2}
    for entry in content["files"]:
        written = (tmp_path / "out" / entry["name"]).read_bytes()
        assert (len(written), hashlib.sha256(written).hexdigest()) == (entry["size"], entry["sha256"])
    there = {path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert {entry["name"] for entry in content["files"]} | {MANIFEST} == there


def test_tracks_in_no_subset_are_reported(tmp_path: Path) -> None:
    data = make_dataset(make_track("m1", range(10, 20)), make_track("m2", range(50, 60)))
    reported = export_dataset(
        data, VIDEO, tmp_path / "out.zip", ExportOptions(split={("a" * 64, "m1"): "train"}), zipped=True
    )
    assert reported.skipped == [{"what": "1 track", "reason": "They are on no side of the split."}]
    assert reported.counts["tracks"] == 1
    with zipfile.ZipFile(tmp_path / "out.zip") as archive:
        assert b"m2" not in archive.read("annotations.xml")


def test_a_manifest_of_another_tool(tmp_path: Path) -> None:
    with pytest.raises(ImportFormatError, match="no manifest.json"):
        read_manifest(tmp_path)
    (tmp_path / MANIFEST).write_text('{"name": "extension"}')
    with pytest.raises(ImportFormatError, match="not a manifest of version 1"):
        read_manifest(tmp_path)
