"""Other libraries read our files as we wrote them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.small_datasets import make_label_set
from tests.oracles.conftest import RunLibrary, assert_same_boxes, boxes_of
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.labels.model import Attribute


def _export(dataset: Dataset, name: str, out: Path, **switches: str) -> Path:
    options = ExportOptions(pictures="all", switches=switches, thin_px=0.5)
    export_dataset(dataset, FORMATS[name], out, options, zipped=False)
    # Libraries must accept our manifest, but MOT readers take all files of a folder.
    return out


@pytest.mark.parametrize(
    ("ours", "theirs", "px"),
    [
        ("coco", "coco", 0.001),
        ("yolo", "yolo", 0.001),
        ("voc", "voc", 0.006),
        ("mot", "mot_seq", 0.011),
        ("datumaro", "datumaro", 0.001),
        ("cvat-images", "cvat", 0.006),
    ],
)
def test_datumaro_reads_boxes(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, ours: str, theirs: str, px: float
) -> None:
    found = run_library("datumaro", "read", theirs, _export(dataset, ours, tmp_path / "out"))
    assert_same_boxes(boxes_of(dataset), found["boxes"], px)


def test_datumaro_reads_tracks_of_cvat(dataset: Dataset, run_library: RunLibrary, tmp_path: Path) -> None:
    found = run_library("datumaro", "read", "cvat", _export(dataset, "cvat-video", tmp_path / "out"))
    shown = [box for box in found["boxes"] if not box[6].get("outside")]
    assert_same_boxes(boxes_of(dataset), shown, 0.006)
    assert len({box[6]["track_id"] for box in shown}) == 2
    # Ends of tracks and gaps: one more box each, marked as outside.
    assert len(found["boxes"]) - len(shown) == 3


@pytest.mark.parametrize(
    ("ours", "theirs"), [("cvat-video", "cvat"), ("cvat-images", "cvat"), ("datumaro", "datumaro"), ("coco", "coco")]
)
def test_datumaro_reads_labels_of_any_country_and_their_attributes(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, ours: str, theirs: str
) -> None:
    asked = (
        Attribute(name="lit", kind="checkbox", mutable=True),
        Attribute(name="side", kind="select", values=("left", "right")),
    )
    names = ("pedestrian_crossing", "elsőbbségadás kötelező", "50")
    (video,) = dataset.videos
    tracks = [
        replace(
            track,
            attributes={"side": "right"},
            changing={"lit": np.array([at % 2 == 0 for at in range(len(track.frames))], object)},
        )
        for track in video.tracks()
    ]
    foreign = Dataset(make_label_set(*names, attributes=asked), (replace(video, tracks=lambda: iter(tracks)),))
    found = run_library("datumaro", "read", theirs, _export(foreign, ours, tmp_path / "out"))
    shown = sorted([box for box in found["boxes"] if not box[6].get("outside")], key=lambda box: box[:2])
    assert_same_boxes(boxes_of(foreign), shown, 0.006)
    assert {box[1] for box in shown} == {names[0], names[2]}
    assert {str(box[6]["side"]) for box in shown} == {"right"}
    lit = {(box[0], box[1]): box[6]["lit"] in (True, "true", "True") for box in shown}
    wanted = {
        (frame, names[track.label]): bool(track.changing["lit"][at])
        for track in tracks
        for at, frame in enumerate(track.frames.tolist())
    }
    assert lit == wanted


def test_datumaro_reads_tracks_of_coco(dataset: Dataset, run_library: RunLibrary, tmp_path: Path) -> None:
    found = run_library("datumaro", "read", "coco", _export(dataset, "coco", tmp_path / "out"))
    by_track: dict[int, int] = {}
    for box in found["boxes"]:
        by_track[box[6]["track_id"]] = by_track.get(box[6]["track_id"], 0) + 1
    assert sorted(by_track.values()) == [4, 6]


def test_datumaro_reads_tracks_of_mot(dataset: Dataset, run_library: RunLibrary, tmp_path: Path) -> None:
    found = run_library("datumaro", "read", "mot_seq", _export(dataset, "mot", tmp_path / "out"))
    assert sorted({box[6]["track_id"] for box in found["boxes"]}) == [1, 2]


@pytest.mark.parametrize(("name", "px"), [("coco", 0.001), ("yolo", 0.001)])
def test_supervision_reads_boxes(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, name: str, px: float
) -> None:
    found = run_library("supervision", "read", name, _export(dataset, name, tmp_path / "out"))
    assert_same_boxes(boxes_of(dataset), found["boxes"], px)


def test_supervision_reads_voc_as_the_devkit_does(dataset: Dataset, run_library: RunLibrary, tmp_path: Path) -> None:
    found = run_library("supervision", "read", "voc", _export(dataset, "voc", tmp_path / "out", coordinates="devkit"))
    assert_same_boxes(boxes_of(dataset), found["boxes"], 0.51)
    # The trap: edges from 0 come back one pixel up and left.
    moved = run_library("supervision", "read", "voc", _export(dataset, "voc", tmp_path / "cvat", coordinates="cvat"))
    assert sorted(moved["boxes"])[0][2] == pytest.approx(boxes_of(dataset)[0][2] - 1, abs=0.51)


def test_pycocotools_reads_and_scores(dataset: Dataset, run_library: RunLibrary, tmp_path: Path) -> None:
    found = run_library("pycocotools", "read", "coco", _export(dataset, "coco", tmp_path / "out"))
    assert_same_boxes(boxes_of(dataset), found["boxes"], 0.001)
    assert found["ap"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("ours", "theirs", "px"),
    [("coco", "coco", 0.001), ("yolo", "yolo", 0.001), ("voc", "voc", 0.006), ("cvat-images", "cvat", 0.006)],
)
def test_globox_reads_boxes(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, ours: str, theirs: str, px: float
) -> None:
    found = run_library("globox", "read", theirs, _export(dataset, ours, tmp_path / "out"))
    assert_same_boxes(boxes_of(dataset), found["boxes"], px)


def test_motmetrics_reads_frames_from_one(dataset: Dataset, run_library: RunLibrary, tmp_path: Path) -> None:
    found = run_library("motmetrics", "read", "mot", _export(dataset, "mot", tmp_path / "out", origin="1"))
    assert_same_boxes(boxes_of(dataset), found["boxes"], 0.011)
    assert {box[6]["track"] for box in found["boxes"]} == {1, 2}


@pytest.mark.parametrize("origin", ["0", "1"])
def test_trackeval_scores_our_truth_against_itself(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, origin: str
) -> None:
    _export(dataset, "mot", tmp_path / "sequence", origin=origin)
    score = run_library("trackeval", "score", "mot", tmp_path)
    assert score["boxes"] == score["counted"] == len(boxes_of(dataset))
    assert (score["HOTA"], score["MOTA"], score["IDF1"]) == (pytest.approx(1.0),) * 3
    assert score["IDSW"] == 0


def test_ultralytics_accepts_the_data_set_for_training(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path
) -> None:
    found = run_library("ultralytics", "check", "yolo", _export(dataset, "yolo", tmp_path / "out"))
    assert found["bad"] == []
    assert found["verified"] == len(boxes_of(dataset))
    assert found["names"] == {str(index): label.name for index, label in enumerate(dataset.labels)}
    assert found["tensor"][0] == 3
    assert_same_boxes(boxes_of(dataset), found["boxes"], 0.001)
