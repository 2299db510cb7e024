"""Invalid boxes in every format: the refusal names the option that leaves them out, and the option does so."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.exchange.image_datasets import assert_refused, read_onto_drive, yolo_folder
from tests.exchange.small_datasets import make_dataset, target_of, tracks_of
from tsr_engine.errors import ImportFormatError, UsageError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS, complete_switches

NAN = math.nan
Box = tuple[Any, Any, Any, Any]
"""``x, y, width, height`` in px; texts are written as they are, None: the number is left out."""
GOOD: Box = (10, 10, 20, 20)


def coco(*boxes: Box) -> dict[str, str]:
    images = [{"id": k, "file_name": f"frame_{10 + k:06d}.jpg", "width": 640, "height": 360} for k in range(len(boxes))]
    notes = [
        {"id": k, "image_id": k, "category_id": 1, "bbox": [side for side in box if side is not None]}
        for k, box in enumerate(boxes)
    ]
    content = {"images": images, "categories": [{"id": 1, "name": "stop"}], "annotations": notes}
    return {"annotations/instances_default.json": json.dumps(content)}


def coco_tracks(*boxes: Box) -> dict[str, str]:
    content = json.loads(coco(*boxes)["annotations/instances_default.json"])
    for note in content["annotations"]:
        note["attributes"] = {"track_id": 1}
    return {"annotations/instances_default.json": json.dumps(content)}


def datumaro(*boxes: Box) -> dict[str, str]:
    items = [
        {
            "id": f"frame_{10 + k:06d}",
            "annotations": [{"type": "bbox", "label_id": 0, "bbox": [side for side in box if side is not None]}],
        }
        for k, box in enumerate(boxes)
    ]
    content = {"categories": {"label": {"labels": [{"name": "stop"}]}}, "items": items}
    return {"annotations/default.json": json.dumps(content)}


def label_studio(*boxes: Box) -> dict[str, str]:
    names = ("x", "y", "width", "height")
    keys = [
        {"frame": 11 + k, "enabled": True}
        | {name: side for name, side in zip(names, box, strict=True) if side is not None}
        for k, box in enumerate(boxes)
    ]
    region = {"id": "a", "type": "videorectangle", "value": {"labels": ["stop"], "sequence": keys}}
    return {"tasks.json": json.dumps([{"data": {"video": "drive.mp4"}, "annotations": [{"result": [region]}]}])}


def tracks_json(*boxes: Box) -> dict[str, str]:
    rows = [{"frame": 10 + k, "bbox": [side for side in box if side is not None]} for k, box in enumerate(boxes)]
    return {"drive.json": json.dumps({"version": 1, "tracks": [{"id": "a", "class": "stop", "boxes": rows}]})}


def tracks_csv(*boxes: Box) -> dict[str, str]:
    rows = [",".join(["" if side is None else str(side) for side in box]) for box in boxes]
    return {"drive.csv": "frame,x,y,w,h\n" + "".join(f"{10 + k},{row}\n" for k, row in enumerate(rows))}


def mot(*boxes: Box) -> dict[str, str]:
    rows = [",".join(["" if side is None else str(side) for side in box]) for box in boxes]
    return {"gt/gt.txt": "".join(f"{11 + k},1,{row},1,14,1\n" for k, row in enumerate(rows))}


def _edges(box: Box) -> list[Any]:
    """``x1, y1, x2, y2``."""
    x, y, w, h = box
    far = [None if side is None else side if isinstance(side, str) else low + side for low, side in ((x, w), (y, h))]
    return [x, y, *far]


def _cvat_rows(boxes: tuple[Box, ...]) -> list[str]:
    names = ("xtl", "ytl", "xbr", "ybr")
    return [
        " ".join(f'{name}="{side}"' for name, side in zip(names, _edges(box), strict=True) if side is not None)
        for box in boxes
    ]


def cvat_video(*boxes: Box) -> dict[str, str]:
    inside = "".join(
        f'<box frame="{10 + k}" keyframe="1" outside="0" occluded="0" {row}/>\n'
        for k, row in enumerate(_cvat_rows(boxes))
    )
    return {"annotations.xml": f'<annotations>\n<track id="0" label="stop">\n{inside}</track>\n</annotations>\n'}


def cvat_images(*boxes: Box) -> dict[str, str]:
    inside = "".join(
        f'<image id="{k}" name="frame_{10 + k:06d}.jpg" width="640" height="360">\n'
        f'<box label="stop" occluded="0" {row}/>\n</image>\n'
        for k, row in enumerate(_cvat_rows(boxes))
    )
    return {"annotations.xml": f"<annotations>\n{inside}</annotations>\n"}


def voc(*boxes: Box) -> dict[str, str]:
    out = {}
    for k, box in enumerate(boxes):
        names = ("xmin", "ymin", "xmax", "ymax")
        corners = "".join(
            f"<{name}>{side}</{name}>" for name, side in zip(names, _edges(box), strict=True) if side is not None
        )
        name = f"frame_{10 + k:06d}"
        out[f"Annotations/{name}.xml"] = (
            f"<annotation><filename>{name}.jpg</filename>\n<object><name>stop</name><bndbox>{corners}</bndbox></object>\n"
            "</annotation>\n"
        )
    return out


def yolo(*boxes: Box) -> dict[str, str]:
    out = {"data.yaml": "names:\n  0: stop\n"}
    for k, box in enumerate(boxes):
        x, y, w, h = (side / 640 if isinstance(side, int | float) else side for side in box)
        row = " ".join(str(side) for side in (x, y, w, h) if side is not None)
        out[f"labels/train/frame_{10 + k:06d}.txt"] = f"0 {row}\n"
    return out


def gtsdb(*boxes: Box) -> dict[str, str]:
    rows = [";".join("" if side is None else str(side) for side in _edges(box)) for box in boxes]
    return {"gt.txt": "".join(f"{10 + k:05d}.ppm;{row};14\n" for k, row in enumerate(rows))}


MAKERS: Mapping[str, tuple[str, Callable[..., dict[str, str]]]] = {
    "coco": ("coco", coco),
    "coco with tracks": ("coco", coco_tracks),
    "datumaro": ("datumaro", datumaro),
    "label-studio": ("label-studio", label_studio),
    "tracks-json": ("tracks-json", tracks_json),
    "tracks-csv": ("tracks-csv", tracks_csv),
    "mot": ("mot", mot),
    "cvat-video": ("cvat-video", cvat_video),
    "cvat-images": ("cvat-images", cvat_images),
    "voc": ("voc", voc),
    "yolo": ("yolo", yolo),
    "gtsdb": ("gtsdb", gtsdb),
}
KINDS: Mapping[str, Box] = {
    "no height": (10, 10, 20, 0),
    "negative width": (40, 10, -20, 20),
    "not a number": (NAN, 10, 20, 20),
    "the last is missing": (10, 10, 20, None),
    "all are missing": (None, None, None, None),
}


def read(folder: Path, kind: str, boxes: tuple[Box, ...], **switches: str) -> Dataset:
    name, make = MAKERS[kind]
    for file, content in make(*boxes).items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(content)
    return read_dataset(folder, target_of(make_dataset(), switches=switches), FORMATS[name])


def frames_of(found: Dataset) -> list[int]:
    return sorted(frame for track in tracks_of(found).values() for frame in track.frames[track.key].tolist())


@pytest.mark.parametrize("kind", list(MAKERS))
@pytest.mark.parametrize("bad", list(KINDS))
def test_an_invalid_box_is_refused_or_left_out_and_reported(tmp_path: Path, kind: str, bad: str) -> None:
    box = KINDS[bad]
    if kind in ("gtsdb", "voc") and bad == "no height":
        box = (10, 10, 20, -1)  # its last pixel counts
    with pytest.raises(ImportFormatError, match=r"\. Or import with bad_boxes=skip, which leaves such boxes out\.$"):
        read(tmp_path, kind, (GOOD, box, GOOD))
    found = read(tmp_path, kind, (GOOD, box, GOOD), bad_boxes="skip")
    assert frames_of(found) == [10, 12]
    (reported,) = [each for each in found.skipped if "bad_boxes=skip" in each.reason]
    assert reported.what == "1 box"
    assert "the first: " in reported.reason
    place = {
        "coco": "annotation 2",
        "coco with tracks": "annotation 2",
        "datumaro": "item 2, box 1",
        "label-studio": "key frame 2",
        "tracks-json": "box 2",
        "tracks-csv": "line 3",
        "mot": "line 2",
        "cvat-video": "line 4",
        "cvat-images": "line 6",
        "voc": "frame_000011.xml, line 2",
        "yolo": "frame_000011.txt, line 1",
        "gtsdb": "line 2",
    }[kind]
    assert place in reported.reason


@pytest.mark.parametrize("kind", list(MAKERS))
def test_invalid_boxes_are_counted_and_valid_ones_not_reported(tmp_path: Path, kind: str) -> None:
    bad = (40, 10, -20, 20)
    found = read(tmp_path, kind, (GOOD, bad, GOOD, bad, bad), bad_boxes="skip")
    assert frames_of(found) == [10, 12]
    assert [each.what for each in found.skipped if "bad_boxes" in each.reason] == ["3 boxes"]
    for file in MAKERS[kind][1](*[bad] * 5):
        (tmp_path / file).unlink()
    found = read(tmp_path, kind, (GOOD, GOOD), bad_boxes="skip")
    assert frames_of(found) == [10, 11]
    assert not [each for each in found.skipped if "bad_boxes" in each.reason]


def test_every_reader_has_the_option_and_no_writer(tmp_path: Path) -> None:
    for known in FORMATS.values():
        if known.read is not None:
            assert complete_switches(known, {}, reading=True)["bad_boxes"] == "refuse"
            with pytest.raises(UsageError, match="bad_boxes of .* must be one of refuse, skip"):
                complete_switches(known, {"bad_boxes": "drop"}, reading=True)
        with pytest.raises(UsageError, match="has no option 'bad_boxes'"):
            complete_switches(known, {"bad_boxes": "skip"}, reading=False)


@pytest.mark.parametrize(
    ("row", "edges"),
    [
        ("-0.0000001 0.5 0.0625 0.1", (0.0, 162.0, 20.0, 198.0)),
        ("1.0000001 0.5 0.0625 0.1", (620.0, 162.0, 640.0, 198.0)),
        ("0.5 -1e-7 0.0625 0.1", (300.0, 0.0, 340.0, 18.0)),
        ("0.5 -0.0099 0.0625 0.1", (300.0, 0.0, 340.0, 14.436)),
        ("-1e-7 -1e-7 0.5 -1e-7 0.5 0.5 -1e-7 0.5", (0.0, 0.0, 320.0, 180.0)),
    ],
)
def test_rounding_beyond_the_picture_is_clipped(tmp_path: Path, row: str, edges: tuple[float, ...]) -> None:
    (track,) = tracks_of(read_onto_drive(yolo_folder(tmp_path, f"0 {row}\n"), "yolo")).values()
    assert track.boxes[0].tolist() == pytest.approx(edges, abs=1e-3)


@pytest.mark.parametrize("row", ["-0.011 0.5 0.1 0.1", "0.5 1.02 0.1 0.1", "120 80 40 40"])
def test_boxes_far_beyond_the_picture_are_refused_with_any_option(tmp_path: Path, row: str) -> None:
    folder = yolo_folder(tmp_path, f"0 {row}\n")
    assert_refused(folder, "yolo", "must be parts of the picture, 0 to 1", bad_boxes="skip")
