"""Faults of files of any format that are refused with file, place and rule: archives, encodings, foreign numbers."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from tests.exchange.label_studio_files import SAMPLE
from tests.exchange.small_datasets import GTSRB, make_dataset, make_track, make_video, target_of, tracks_of
from tsr_engine.errors import ExportError, ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

Given = tuple[str, Mapping[str, str | bytes]]
"""A format and the files of an archive."""


def cvat(left: str = "10", **more: str) -> Given:
    """An annotations.xml with its box in line 3."""
    box = f'<box frame="10" keyframe="1" outside="0" occluded="0" xtl="{left}" ytl="10" xbr="30" ybr="30"/>'
    text = f'<annotations>\n<track id="0" label="stop">\n{box}\n</track>\n</annotations>\n'
    return "cvat-video", {"annotations.xml": text, **more}


def yolo(text: str, encoding: str = "utf-8") -> Given:
    """Labels of frame 10."""
    return "yolo", {"data.yaml": "names: [stop]\n", "labels/train/frame_000010.txt": f"{text}\n".encode(encoding)}


def mot(row: str) -> Given:
    """A row of ground truth."""
    return "mot", {"gt/gt.txt": f"{row}\n", "gt/labels.txt": "stop\nyield\n"}


def table(rows: str) -> Given:
    """A table with these rows."""
    return "tracks-csv", {"drive.csv": f"frame,track_id,x1,y1,x2,y2\n{rows}\n"}


REFUSED: dict[str, tuple[Given, str]] = {
    "zip slip": (cvat(**{"../../evil.sh": "x"}), "bad.zip.*evil.sh.*leads out of its folder"),
    "zip bomb": (("cvat-video", {"a.xml": bytes(4 << 20)}), "bad.zip.*a.xml.*more than 250 times"),
    "latin-1": (yolo("0 0.5 0.5 0.1 0.1\n# größe", "latin-1"), "frame_000010.txt.*line 2.*not UTF-8"),
    "utf-16": (("coco", {"a.json": "{}".encode("utf-16")}), "a.json.*line 1.*UTF-16; must be UTF-8"),
    "no encoding": (("cvat-video", {"a.xml": '<?xml version="1.0" encoding="klingon"?><a/>'}), "a.xml.*line 1.*UTF-8"),
    "digits of another script": (mot("1,1,\u0661\u0660,10,9,5,1,1,1"), "gt.txt.*line 1.*column 3"),
    "a Python number in rows": (mot("1_0,1,10,10,9,5,1,1,1"), "gt.txt.*line 1.*column 1 must be a number"),
    "a Python number in text": (yolo("0 0.5_0 0.5 0.1 0.1"), "frame_000010.txt.*line 1.*must be numbers"),
    "a Python number in a table": (table("1,1,1,1,9,9\n2,1,1,1,1_0,9"), "drive.csv.*line 3.*x2 must be a number"),
    "a Python number as a frame": (table("1_0,1,1,1,9,9"), "drive.csv.*line 2.*frame '1_0' must be a whole number"),
    "a Python number in a list": (("gtsdb", {"gt.txt": "00010.ppm;1_0;11;29;32;14\n"}), "gt.txt.*whole numbers"),
    "a Python number in xml": (cvat("1_0"), "annotations.xml.*line 3.*a number"),
}


def _zip(folder: Path, files: Mapping[str, str | bytes]) -> Path:
    with zipfile.ZipFile(folder / "bad.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return folder / "bad.zip"


@pytest.mark.parametrize(("given", "says"), REFUSED.values(), ids=list(REFUSED))
def test_a_fault_is_refused_with_file_place_and_rule(tmp_path: Path, given: Given, says: str) -> None:
    name, files = given
    with pytest.raises(ImportFormatError, match=f"(?s){says}"):
        read_dataset(_zip(tmp_path, files), target_of(make_dataset()), FORMATS[name], scratch=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["bad.zip"], "what was unpacked is gone"


@pytest.mark.parametrize("given", [cvat(), yolo("0 0.5 0.5 0.1 0.1"), mot("1,1,10,10,5,5,1,1,1"), table("1,1,1,1,9,9")])
def test_the_files_are_valid_without_their_fault(tmp_path: Path, given: Given) -> None:
    back = read_dataset(_zip(tmp_path, given[1]), target_of(make_dataset()), FORMATS[given[0]])
    assert (len(tracks_of(back)), back.skipped) == (1, ())


def test_a_video_of_variable_rate_and_label_studio(tmp_path: Path) -> None:
    shaky = replace(make_video([make_track()]), constant_rate=False)
    data = Dataset(GTSRB, (shaky,))
    with pytest.raises(ExportError, match=r"drive\.mp4 has a variable frame rate.*Convert it"):
        export_dataset(data, FORMATS["label-studio"], tmp_path / "out", zipped=False)
    assert not list(tmp_path.iterdir())
    (tmp_path / "tasks.json").write_text(json.dumps(SAMPLE))
    with pytest.raises(ImportFormatError, match=r"tasks\.json: counts frames by time.*variable frame rate"):
        read_dataset(tmp_path / "tasks.json", target_of(data), FORMATS["label-studio"])


def test_a_list_of_entries_over_the_limit_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = _zip(tmp_path, {f"{k}": "" for k in range(3)})
    content = bytearray(path.read_bytes())
    at = content.rindex(b"PK\x05\x06")
    content[at + 8 : at + 12] = (60_000).to_bytes(2, "little") * 2
    content[at + 12 : at + 16] = (1 << 30).to_bytes(4, "little")
    path.write_bytes(content)
    with pytest.raises(ImportFormatError, match=r"bad\.zip: the archive is damaged"):  # it is too small for such a list
        read_dataset(path, target_of(make_dataset()))
    with path.open("wb") as file:
        file.seek(1 << 30)  # zeros in a sparse file
        file.write(content)
    with pytest.raises(ImportFormatError, match=r"bad\.zip: has a list of entries of 1073741824 bytes; at most 400000"):
        read_dataset(path, target_of(make_dataset()))
