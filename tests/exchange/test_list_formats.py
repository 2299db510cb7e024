"""Traps of COCO, YOLO and Pascal VOC: each is repaired, or refused with file, place and rule."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.image_datasets import assert_refused, read_onto_drive, yolo_folder
from tests.exchange.small_datasets import make_dataset, make_label_set, make_track, tracks_of
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.registry import FORMATS

# ---------------------------------------------------------------------------------------------------------------- COCO


def _coco(folder: Path, **changes: object) -> Path:
    content: dict[str, object] = {
        "images": [{"id": 1, "width": 640, "height": 360, "file_name": "frame_000010.jpg"}],
        "categories": [{"id": 1, "name": "stop"}],
        "annotations": [{"id": 1, "image_id": 1, "category_id": 1, "bbox": [10, 10, 20, 22]}],
    }
    content.update(changes)
    path = folder / "instances.json"
    path.write_text(json.dumps(content))
    return path


def _note(**changes: object) -> list[object]:
    return [{"id": 1, "image_id": 1, "category_id": 1, "bbox": [10, 10, 20, 22], **changes}]


def test_coco_of_another_tool_is_read(tmp_path: Path) -> None:
    back = read_onto_drive(_coco(tmp_path), "coco")
    (track,) = tracks_of(back).values()
    assert (track.frames.tolist(), track.label, track.boxes.tolist()) == ([10], 14, [[10, 10, 30, 32]])
    assert any("no track id" in sentence for sentence in back.repaired)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"annotations": _note(bbox=[10, 10, -5, 22])}, ("instances.json", "annotation 1", "positive width")),
        ({"annotations": _note(bbox=[10, 10, 20])}, ("annotation 1", "four numbers")),
        ({"annotations": _note(bbox=["a", 1, 2, 3])}, ("annotation 1", "must be a finite number")),
        ({"annotations": _note(category_id=7)}, ("annotation 1", "category_id '7'")),
        ({"annotations": _note(image_id=9)}, ("annotation 1", "image_id '9'")),
        ({"annotations": _note(score=1.5)}, ("annotation 1", "score")),
        ({"annotations": [3]}, ("must have annotations",)),
        ({"categories": [{"id": 1, "name": "a"}, {"id": 1, "name": "b"}]}, ("category 2", "twice")),
        ({"images": [{"id": 1, "file_name": "frame_1.jpg"}] * 2}, ("image 2", "twice")),
        ({"images": [{"id": 1, "file_name": "frame_000100.jpg"}]}, ("image 1", "0 to 99")),
        ({"images": [{"id": 1, "file_name": "picture.jpg"}]}, ("image 1", "no frame number")),
        ({"images": [{"id": 1, "file_name": "frame_000001.jpg", "width": 64, "height": 36}]}, ("64x36", "size=scale")),
    ],
)
def test_coco_that_breaks_a_rule(tmp_path: Path, changes: dict[str, object], words: tuple[str, ...]) -> None:
    assert_refused(_coco(tmp_path, **changes), "coco", *words)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
def test_coco_with_invalid_numbers_is_refused(tmp_path: Path, number: str) -> None:
    path = _coco(tmp_path)
    path.write_text(path.read_text().replace("[10, 10,", f"[{number}, 10,"))
    assert_refused(path, "coco", "instances.json", "finite")


def test_coco_results_are_detections(tmp_path: Path) -> None:
    results = [{"image_id": k + 1, "category_id": 15, "bbox": [10.0 + k, 10, 20, 20], "score": 0.5} for k in range(4)]
    path = tmp_path / "predictions.json"
    path.write_text(json.dumps(results))
    back = read_onto_drive(path, "coco")
    (track,) = tracks_of(back).values()
    assert (track.frames.tolist(), track.label, track.score.tolist()) == ([0, 1, 2, 3], 14, [0.5] * 4)
    assert any("counted from 1" in sentence for sentence in back.repaired)
    from_zero = [dict(result, image_id=result["image_id"] - 1) for result in results]
    path.write_text(json.dumps(from_zero))
    assert_refused(path, "coco", "predictions.json, result 1", "counts from 0 or 1")


def test_coco_results_beside_their_images(tmp_path: Path) -> None:
    _coco(tmp_path, images=[{"id": "x", "file_name": "frame_000042.jpg"}], annotations=[])
    (tmp_path / "results.json").write_text(
        json.dumps([{"image_id": "x", "category_id": 1, "bbox": [1, 2, 30, 40], "score": 0.25}])
    )
    (track,) = tracks_of(read_onto_drive(tmp_path, "coco")).values()
    assert (track.frames.tolist(), track.label, track.score.tolist()) == ([42], 14, [0.25])


def test_ignored_boxes_are_coco_crowds(tmp_path: Path) -> None:
    held = np.array([True, False])
    dataset = make_dataset(make_track("m1", [1, 2], ignore=held))
    export_dataset(dataset, FORMATS["coco"], tmp_path / "out", zipped=False)
    content = json.loads((tmp_path / "out/annotations/instances_default.json").read_text())
    assert [note["iscrowd"] for note in content["annotations"]] == [1, 0]
    assert [image["id"] for image in content["images"]] == [2, 3]
    assert content["categories"][0]["id"] == 1


# ---------------------------------------------------------------------------------------------------------------- YOLO


def test_yolo_has_five_columns_and_a_file_of_tracks(tmp_path: Path) -> None:
    dataset = make_dataset()
    export_dataset(dataset, FORMATS["yolo"], tmp_path / "out", zipped=False)
    for path in (tmp_path / "out" / "labels" / "train").iterdir():
        for line in path.read_text().splitlines():
            cells = line.split()
            assert len(cells) == 5
            assert all(0 <= float(cell) <= 1 and len(cell.split(".")[1]) >= 6 for cell in cells[1:])
    assert "path:" not in (tmp_path / "out" / "data.yaml").read_text()
    assert set(tracks_of(read_onto_drive(tmp_path / "out", "yolo"))) == {"m1", "m2", "h3"}


def test_yolo_keeps_tracks_of_boxes_that_were_edited(tmp_path: Path) -> None:
    export_dataset(make_dataset(), FORMATS["yolo"], tmp_path / "out", zipped=False)
    path = tmp_path / "out" / "labels" / "train" / "frame_000020.txt"
    lines = path.read_text().splitlines()
    assert len(lines) == 2
    path.write_text(f"{lines[1]}\n0 0.5 0.5 0.1 0.1\n")
    back = read_onto_drive(tmp_path / "out", "yolo")
    assert set(tracks_of(back)) == {"m1", "m2", "h3"}
    moved = tracks_of(back)["m1"]
    assert moved.boxes[moved.frames.tolist().index(20)].tolist() == pytest.approx([288, 162, 352, 198])
    assert any("kept the track of their line" in sentence for sentence in back.repaired)


def test_yolo_leaves_out_ignored_boxes(tmp_path: Path) -> None:
    dataset = make_dataset(make_track("m1", [1, 2], ignore=np.array([True, False])))
    reported = export_dataset(dataset, FORMATS["yolo"], tmp_path / "out", zipped=False)
    assert (tmp_path / "out/labels/train/frame_000001.txt").read_text() == ""
    assert any("to ignore" in item["what"] for item in reported.skipped)
    kept = ExportOptions(switches={"ignored": "box"})
    export_dataset(dataset, FORMATS["yolo"], tmp_path / "out", kept, zipped=False)
    track = tracks_of(read_onto_drive(tmp_path / "out", "yolo"))["m1"]
    assert track.ignore is not None
    assert track.ignore.tolist() == [True, False]


@pytest.mark.parametrize(
    ("sixth", "kind"),
    [(("7", "8"), "track ids"), (("0.9", "1"), "confidences"), (("1", "1"), "confidences"), (("0", "1"), "track ids")],
)
def test_yolo_with_six_columns_is_reported(tmp_path: Path, sixth: tuple[str, str], kind: str) -> None:
    rows = [f"0 0.{index + 2} 0.5 0.1 0.1 {number}\n" for index, number in enumerate(sixth)]
    back = read_onto_drive(yolo_folder(tmp_path, "".join(rows)), "yolo")
    (reported,) = [sentence for sentence in back.repaired if "5 columns" in sentence]
    assert "labels/train/frame_000010.txt, line 1" in reported
    assert kind in reported
    scores = [track.score[0] for track in tracks_of(back).values()]
    assert np.isnan(scores).all() == (kind == "track ids")
    assert len(scores) == 2


def test_yolo_reads_the_sixth_column_alike_in_all_files(tmp_path: Path) -> None:
    yolo_folder(tmp_path, "0 0.5 0.5 0.1 0.1 1\n", frame=3)
    back = read_onto_drive(yolo_folder(tmp_path, "0 0.5 0.5 0.1 0.1 0.75\n", frame=4), "yolo")
    (track,) = tracks_of(back).values()
    assert track.score.tolist() == [1.0, 0.75]
    yolo_folder(tmp_path, "0 0.5 0.5 0.1 0.1 3\n", frame=3)
    assert_refused(tmp_path, "yolo", "labels/train/frame_000003.txt, line 1", "sixth column", "3")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0 nan 0.5 0.1 0.1", ("line 1", "finite")),
        ("0 0.5 0.5 0.1", ("line 1", "5 columns", "Got 4")),
        ("0 -0.1 0.5 0.1 0.1", ("line 1", "0 to 1")),
        ("0 120 80 20 20", ("line 1", "look like pixels")),
        ("0 0.5 0.5 0 0.1", ("line 1", "positive width")),
        ("2 0.5 0.5 0.1 0.1", ("line 1", "class 2", "data.yaml")),
        ("1.5 0.5 0.5 0.1 0.1", ("line 1", "whole number")),
        ("stop 0.5 0.5 0.1 0.1", ("line 1", "must be numbers")),
    ],
)
def test_yolo_that_breaks_a_rule(tmp_path: Path, line: str, words: tuple[str, ...]) -> None:
    assert_refused(yolo_folder(tmp_path, f"{line}\n"), "yolo", "labels/train/frame_000010.txt", *words)


def test_yolo_files_beyond_the_video_or_without_a_number(tmp_path: Path) -> None:
    assert_refused(
        yolo_folder(tmp_path / "far", "0 0.5 0.5 0.1 0.1\n", frame=100), "yolo", "frame_000100.txt", "0 to 99"
    )
    named = yolo_folder(tmp_path / "named", "0 0.5 0.5 0.1 0.1\n")
    (named / "labels/train/frame_000010.txt").rename(named / "labels/train/picture.txt")
    assert_refused(named, "yolo", "picture.txt", "no frame number")


def test_yolo_clips_boxes_and_reads_polygons(tmp_path: Path) -> None:
    back = read_onto_drive(yolo_folder(tmp_path, "0 0.0 0.5 0.2 0.2\n1 0.1 0.1 0.3 0.1 0.3 0.3 0.1 0.3\n"), "yolo")
    boxes = sorted(tuple(np.round(track.boxes[0], 6)) for track in tracks_of(back).values())
    assert boxes == [(0.0, 144.0, 64.0, 216.0), (64.0, 36.0, 192.0, 108.0)]
    assert any("cut" in sentence for sentence in back.repaired)
    assert any("Polygons" in sentence for sentence in back.repaired)


def test_a_repeated_box_without_a_track_is_taken_once(tmp_path: Path) -> None:
    """Ultralytics also removes duplicate labels of a picture (ultralytics/yolov5#5210)."""
    for frame in (10, 11):
        yolo_folder(tmp_path, "0 0.5 0.5 0.1 0.1\n1 0.5 0.5 0.1 0.1\n0 0.5 0.5 0.1 0.1\n", frame=frame)
    back = read_onto_drive(tmp_path, "yolo")
    found = [(track.label, track.frames.tolist()) for track in tracks_of(back).values()]
    assert sorted(found) == [(13, [10, 11]), (14, [10, 11])]
    assert any("Repeated boxes were taken once: 2" in sentence for sentence in back.repaired)


def test_yolo_in_another_encoding(tmp_path: Path) -> None:
    path = yolo_folder(tmp_path, "0 0.5 0.5 0.1 0.1\n")
    (path / "data.yaml").write_bytes("names: [Überholverbot]\n".encode("latin-1"))
    assert_refused(path, "yolo", "data.yaml, line 1", "UTF-8")


# ----------------------------------------------------------------------------------------------------------------- VOC


def _voc(folder: Path, box: tuple[object, ...], *, name: str = "stop", head: str = "", frame: int = 10) -> Path:
    (folder / "Annotations").mkdir(parents=True, exist_ok=True)
    corners = "".join(
        f"<{tag}>{value}</{tag}>" for tag, value in zip(("xmin", "ymin", "xmax", "ymax"), box, strict=True)
    )
    (folder / "Annotations" / f"frame_{frame:06d}.xml").write_text(
        f"{head}<annotation><size><width>640</width><height>360</height><depth>3</depth></size>\n"
        f"<object><name>{name}</name>\n<bndbox>{corners}</bndbox></object></annotation>"
    )
    return folder


def _only_box(dataset: Dataset) -> list[float]:
    (track,) = tracks_of(dataset).values()
    return track.boxes[0].tolist()


def test_voc_is_written_with_both_box_conventions(tmp_path: Path) -> None:
    dataset = make_dataset(make_track("m1", [10], boxes=[(10, 10, 20, 22)]))
    for kind, corner in (("cvat", "<xmin>10.00</xmin>"), ("devkit", "<xmin>11</xmin>")):
        options = ExportOptions(switches={"coordinates": kind})
        reported = export_dataset(dataset, FORMATS["voc"], tmp_path / kind, options, zipped=False)
        text = (tmp_path / kind / "Annotations" / "frame_000010.xml").read_text()
        assert corner in text
        assert "<xmax>20" in text
        assert reported.content["format"]["coordinates"] == kind
        assert _only_box(read_onto_drive(tmp_path / kind, "voc")) == [10, 10, 20, 22]


def test_voc_of_another_tool_is_read_by_its_coordinates(tmp_path: Path) -> None:
    devkit = read_onto_drive(_voc(tmp_path / "a", (11, 11, 20, 22)), "voc")
    assert _only_box(devkit) == [10, 10, 20, 22]
    assert any("lowered by 1" in sentence for sentence in devkit.repaired)
    assert _only_box(read_onto_drive(tmp_path / "a", "voc", coordinates="cvat")) == [11, 11, 20, 22]
    assert _only_box(read_onto_drive(_voc(tmp_path / "b", (10.5, 11, 20, 22)), "voc")) == [10.5, 11, 20, 22]
    zero = _voc(tmp_path / "c", (0, 11, 20, 22))
    assert _only_box(read_onto_drive(zero, "voc")) == [0, 11, 20, 22]
    assert_refused(zero, "voc", "frame_000010.xml, line 2", "cannot count from 1", coordinates="devkit")


@pytest.mark.parametrize(
    ("box", "words"),
    [
        (("nan", 1, 20, 22), ("frame_000010.xml, line 2", "finite")),
        ((20, 10, 10, 22), ("frame_000010.xml, line 2", "positive width")),
        (("ten", 10, 10, 22), ("frame_000010.xml, line 3", "<xmin>", "number")),
    ],
)
def test_voc_that_breaks_a_rule(tmp_path: Path, box: tuple[object, ...], words: tuple[str, ...]) -> None:
    assert_refused(_voc(tmp_path, box), "voc", *words)


def test_voc_with_entities(tmp_path: Path) -> None:
    head = '<!DOCTYPE a [<!ENTITY e SYSTEM "file:///etc/passwd">]>'
    assert_refused(_voc(tmp_path, (1, 2, 3, 4), head=head, name="&e;"), "voc", "frame_000010.xml, line 1", "DOCTYPE")


def test_voc_with_unknown_classes(tmp_path: Path) -> None:
    with pytest.raises(UnknownLabels, match=r"'zebra' \(1 track, 1 box\)"):
        read_onto_drive(_voc(tmp_path, (1.5, 2, 30, 40), name="zebra"), "voc")


def test_voc_names_with_colons(tmp_path: Path) -> None:
    dataset = Dataset(make_label_set("a:b"), make_dataset(make_track("m1", [1], label=0)).videos)
    reported = export_dataset(dataset, FORMATS["voc"], tmp_path / "out", zipped=False)
    assert not (tmp_path / "out" / "labelmap.txt").exists()
    assert any("colon" in item["reason"] for item in reported.skipped)
