"""Common faults in files of other tools: each is refused or repaired, with file, place and rule."""

from __future__ import annotations

import io
import json
import math
import re
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.exchange.small_datasets import GTSRB, make_dataset, make_track, make_video, target_of, tracks_of
from tsr_engine.errors import ExportError, ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS


class Given(NamedTuple):
    """Files of an import."""

    files: Mapping[str, str | bytes]
    format: str = "cvat-video"
    switches: Mapping[str, str] = {}


def cvat(box: str = 'frame="10"', before: str = "", label: str = "stop") -> Given:
    """An annotations.xml with its box in line 4."""
    edges = 'xtl="10" ytl="10" xbr="30" ybr="30"'
    for given in re.findall(r'(x..|y..)="', box):
        edges = re.sub(rf'{given}="[^"]*" ?', "", edges)
    return Given(
        {
            "annotations.xml": f'<?xml version="1.0" encoding="utf-8"?>{before}\n<annotations>\n'
            f'<track id="0" label="{label}">\n<box {box} keyframe="1" outside="0" occluded="0" {edges}/>\n</track>\n'
            "</annotations>\n"
        }
    )


def coco(note: Mapping[str, object] | None = None, **changes: object) -> Given:
    """A file with one box in frame 10."""
    annotation = {"id": 1, "image_id": 1, "category_id": 1, "bbox": [10, 10, 20, 20]}
    content = {
        "images": [{"id": 1, "file_name": "frame_000010.jpg", "width": 640, "height": 360}],
        "categories": [{"id": 1, "name": "stop"}],
        "annotations": [{**annotation, **(note or {})}],
    }
    return Given({"annotations/a.json": json.dumps({**content, **changes})}, "coco")


def yolo(*lines: str, encoding: str = "utf-8") -> Given:
    """Labels of frame 10."""
    text = "\n".join(lines) + "\n"
    return Given(
        {"data.yaml": "names:\n  0: stop\n  1: yield\n", "labels/train/frame_000010.txt": text.encode(encoding)}, "yolo"
    )


def mot(*lines: str) -> Given:
    """Rows of ground truth."""
    return Given({"gt/gt.txt": "\n".join(lines) + "\n", "gt/labels.txt": "stop\nyield\n"}, "mot")


def voc(corners: tuple[object, ...] = (10, 10, 30, 30), name: str = "frame_000010") -> Given:
    """One picture with its object in line 2."""
    xmin, ymin, xmax, ymax = corners
    return Given(
        {
            f"Annotations/{name}.xml": f"<annotation><filename>{name}.jpg</filename>\n<object><name>stop</name>"
            f"<bndbox><xmin>{xmin}</xmin><ymin>{ymin}</ymin><xmax>{xmax}</xmax><ymax>{ymax}</ymax></bndbox></object>\n"
            "</annotation>\n"
        },
        "voc",
    )


def label_studio(frame: int = 11, width: float = 10.0) -> Given:
    """One region with one key frame."""
    key = {"frame": frame, "x": 10, "y": 10, "width": width, "height": 10, "enabled": False}
    region = {"id": "a", "type": "videorectangle", "value": {"labels": ["stop"], "sequence": [key]}}
    return Given(
        {"tasks.json": json.dumps([{"data": {"video": "drive.mp4"}, "annotations": [{"result": [region]}]}])},
        "label-studio",
    )


def table(rows: str) -> Given:
    """A table with these rows."""
    return Given({"drive.csv": f"frame,track_id,x1,y1,x2,y2\n{rows}\n"}, "tracks-csv")


def packed(files: Mapping[str, str | bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


LAUGHS = '\n<!DOCTYPE a [<!ENTITY b "ha"><!ENTITY c "&b;&b;&b;&b;">]>'
OUTSIDE = '\n<!DOCTYPE a SYSTEM "file:///etc/passwd">'
TRACK = {"id": "m1", "boxes": [{"frame": 1, "box": [1, 1, 9, 9]}]}
REFUSED: dict[str, tuple[Given, str]] = {
    "xml entities": (cvat(before=LAUGHS), "annotations.xml.*line 2.*DOCTYPE or entity"),
    "xml external reference": (cvat(before=OUTSIDE), "annotations.xml.*line 2.*DOCTYPE or entity"),
    "xml entities, by picture": (
        Given({"Annotations/frame_000010.xml": '<!DOCTYPE a [<!ENTITY b "x">]><annotation>&b;</annotation>'}, "voc"),
        "frame_000010.xml.*line 1.*DOCTYPE or entity",
    ),
    "zip slip": (Given({**cvat().files, "../../evil.sh": "x"}), "bad.zip.*evil.sh.*leads out of its folder"),
    "zip slip, absolute": (Given({**cvat().files, "/etc/evil": "x"}), "bad.zip.*etc/evil.*absolute name"),
    "zip bomb": (Given({"annotations.xml": bytes(4 << 20)}), "bad.zip.*annotations.xml.*more than 250 times"),
    "nested archive": (Given({"more.zip": packed(cvat().files)}), "bad.zip.*more.zip.*an archive within the archive"),
    "nested archive under another name": (
        Given({"annotations.xml": packed(cvat().files)}),
        "bad.zip.*annotations.xml.*an archive within the archive",
    ),
    "encoding: latin-1": (
        yolo("0 0.5 0.5 0.1 0.1", "# größe", encoding="latin-1"),
        "frame_000010.txt.*line 2.*not UTF-8",
    ),
    "encoding: utf-16": (
        Given({"annotations/a.json": "{}".encode("utf-16")}, "coco"),
        "a.json.*line 1.*UTF-16; must be UTF-8",
    ),
    "encoding: none that exists": (
        Given({"annotations.xml": '<?xml version="1.0" encoding="klingon"?><annotations/>'}),
        "annotations.xml.*line 1.*UTF-8",
    ),
    "nan in xml": (cvat('frame="10" xtl="nan"'), "annotations.xml.*line 4.*four finite numbers"),
    "nan in json": (
        coco({"bbox": [math.nan, 1, 2, 3]}),
        "a.json.*annotation 1.*bbox must be a finite number.*NaN.*bad_boxes=skip",
    ),
    "nan in text": (yolo("0 nan 0.5 0.1 0.1"), "frame_000010.txt.*line 1.*finite numbers"),
    "a Python number in rows": (mot("1_0,1,10,10,9,5,1,1,1"), "gt.txt.*line 1.*column 1 must be a number"),
    "digits of another script": (mot("1,1,\u0661\u0660,10,9,5,1,1,1"), "gt.txt.*line 1.*column 3"),
    "a Python number in text": (yolo("0 0.5_0 0.5 0.1 0.1"), "frame_000010.txt.*line 1.*must be numbers"),
    "a Python number in a table": (table("1,1,1,1,9,9\n2,1,1,1,1_0,9"), "drive.csv.*line 3.*x2 must be a number"),
    "a Python number as a frame": (table("1_0,1,1,1,9,9"), "drive.csv.*line 2.*frame '1_0' must be a whole number"),
    "a Python number in a list": (Given({"gt.txt": "00010.ppm;1_0;11;29;32;14\n"}, "gtsdb"), "gt.txt.*whole numbers"),
    "a Python number in xml": (cvat('frame="10" xtl="1_0"'), "annotations.xml.*line 4.*a number"),
    "infinite box": (mot("1,1,10,10,inf,5,1,1,1"), "gt.txt.*line 1.*four finite numbers"),
    "negative box in xml": (cvat('frame="10" xbr="5"'), "annotations.xml.*line 4.*positive width and height"),
    "negative box in json": (coco({"bbox": [10, 10, -5, 20]}), "a.json.*annotation 1.*positive width and height"),
    "negative box in text": (yolo("0 0.5 0.5 -0.1 0.1"), "frame_000010.txt.*line 1.*positive width"),
    "negative box of a region": (
        label_studio(width=-1),
        "tasks.json.*region 1, key frame 1.*positive width and height",
    ),
    "frame out of range in xml": (cvat('frame="3000"'), "annotations.xml.*line 4.*frame 3000 must be in 0 to 99"),
    "frame out of range in a name": (voc(name="frame_003000"), "frame_003000.xml.*0 to 99"),
    "frame out of range in rows": (
        table("1,1,1,1,9,9\n100,1,1,1,9,9"),
        "drive.csv.*line 3.*frame 100 must be in 0 to 99",
    ),
    "unknown class number": (
        yolo("7 0.5 0.5 0.1 0.1"),
        "frame_000010.txt.*line 1.*class 7 is none of the 2 classes in data.yaml",
    ),
    "unknown class id": (coco({"category_id": 9}), "a.json.*annotation 1.*matches no category"),
    "duplicate category": (
        coco(categories=[{"id": 1, "name": "stop"}, {"id": 1, "name": "yield"}]),
        "a.json.*category 2.*id 1 occurs twice",
    ),
    "duplicate picture": (
        coco(images=[{"id": 1, "file_name": "frame_000010.jpg"}, {"id": 1, "file_name": "frame_000011.jpg"}]),
        "a.json.*image 2.*id 1 occurs twice",
    ),
    "duplicate track": (
        Given({"drive.json": json.dumps({"tracks": [TRACK, TRACK]})}, "tracks-json"),
        "drive.json.*track 2.*called 'm1'",
    ),
    "duplicate box": (
        mot("1,1,10,10,5,5,1,1,1", "1,1,50,10,5,5,1,1,1"),
        "gt.txt.*line 2.*second, different box in frame 0",
    ),
    "duplicate key": (
        Given({"annotations/a.json": '{"images": [],\n"images": []}'}, "coco"),
        "a.json.*line 2.*'images' twice",
    ),
    "six columns that are neither": (
        yolo("0 0.5 0.5 0.1 0.1 0.5", "0 0.2 0.2 0.1 0.1 7.0"),
        "frame_000010.txt.*line 2.*sixth column must be",
    ),
    "frame 0 where frames count from 1": (
        mot("0,1,10,10,5,5,1,1,1"),
        "gt.txt.*line 1.*1 to 100.*whether the file counts from 0 or 1",
    ),
    "class 0 where classes count from 1": (
        mot("1,1,10,10,5,5,1,0,1"),
        "gt.txt.*line 1.*class 0 must be 1 to 2.*first_class=0",
    ),
    "frame 0 of a region": (label_studio(frame=0), "tasks.json.*key frame 1.*1 to 100"),
    "corner 0 where pixels count from 1": (
        voc((0, 10, 30, 30))._replace(switches={"coordinates": "devkit"}),
        "frame_000010.xml.*line 2.*cannot count from 1",
    ),
}

REPAIRED: dict[str, tuple[Given, str]] = {
    "six columns": (yolo("0 0.5 0.5 0.1 0.1 3"), "labels/train/frame_000010.txt, line 1.*5 columns.*track ids"),
    "duplicate row": (
        mot("1,1,10,10,5,5,1,1,1", "1,1,10,10,5,5,1,1,1"),
        "Repeated boxes were taken once.*gt.txt, line 2",
    ),
    "pixels that look like the devkit's": (voc(), "whole numbers from 1 on.*lowered by 1"),
    "box over the edge": (cvat('frame="10" xtl="-4"'), "cut there: 1.*annotations.xml, line 4"),
}


def _zip(folder: Path, files: Mapping[str, str | bytes]) -> Path:
    path = folder / "bad.zip"
    path.write_bytes(packed(files))
    return path


@pytest.mark.parametrize(("bad", "says"), REFUSED.values(), ids=list(REFUSED))
def test_a_fault_is_refused_with_file_place_and_rule(tmp_path: Path, bad: Given, says: str) -> None:
    target = target_of(make_dataset(), switches=bad.switches)
    with pytest.raises(ImportFormatError, match=f"(?s){says}"):
        read_dataset(_zip(tmp_path, bad.files), target, FORMATS[bad.format], scratch=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["bad.zip"], "what was unpacked is gone"


@pytest.mark.parametrize(("bad", "says"), REPAIRED.values(), ids=list(REPAIRED))
def test_a_fault_is_repaired_and_reported(tmp_path: Path, bad: Given, says: str) -> None:
    back = read_dataset(_zip(tmp_path, bad.files), target_of(make_dataset()), FORMATS[bad.format])
    assert any(re.search(says, sentence) for sentence in back.repaired), back.repaired
    assert sum(len(track.frames) for track in tracks_of(back).values()) >= 1


@pytest.mark.parametrize(
    "given",
    [
        cvat(),
        coco(),
        yolo("0 0.5 0.5 0.1 0.1"),
        mot("1,1,10,10,5,5,1,1,1"),
        voc((10.5, 10, 30, 30)),
        label_studio(),
        Given({"drive.json": json.dumps({"tracks": [TRACK]})}, "tracks-json"),
    ],
    ids=lambda given: given.format,
)
def test_the_files_are_valid_without_their_fault(tmp_path: Path, given: Given) -> None:
    """Each file above has only the fault that it tests."""
    back = read_dataset(_zip(tmp_path, given.files), target_of(make_dataset()), FORMATS[given.format])
    reported = [sentence for sentence in back.repaired if "linked" not in sentence and "corners" not in sentence]
    assert (len(tracks_of(back)), reported, back.skipped) == (1, [], ())


def test_a_video_of_variable_rate_and_label_studio(tmp_path: Path) -> None:
    shaky = replace(make_video([make_track()]), constant_rate=False)
    data = Dataset(GTSRB, (shaky,))
    with pytest.raises(ExportError, match=r"drive\.mp4 has a variable frame rate.*Convert it"):
        export_dataset(data, FORMATS["label-studio"], tmp_path / "out", zipped=False)
    assert not list(tmp_path.iterdir())
    (tmp_path / "tasks.json").write_text(str(label_studio().files["tasks.json"]))
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
