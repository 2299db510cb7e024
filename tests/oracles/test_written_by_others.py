"""We read the files of other libraries."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.oracles.conftest import RunLibrary, assert_same_boxes, boxes_of, target
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.labels import label_name
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS


def _json_of(dataset: Dataset) -> list[Any]:
    """All boxes with their track attributes."""
    out = []
    for number, track in enumerate(dataset.videos[0].tracks(), start=1):
        for frame, box in zip(track.frames.tolist(), track.boxes.tolist(), strict=True):
            said = {"track_id": number, "keyframe": True, "occluded": False, "outside": False}
            out.append([frame, label_name(dataset.labels, track.label), *box, said])
    return out


@pytest.mark.parametrize(
    ("theirs", "ours", "px", "tracks"),
    [
        ("coco_instances", "coco", 0.011, 2),
        ("datumaro", "datumaro", 0.011, 2),
        ("mot_seq_gt", "mot", 0.011, 2),
        ("voc_detection", "voc", 0.011, 2),
        ("yolo", "yolo", 0.011, 3),
        ("cvat", "cvat-images", 0.011, 10),
    ],
)
def test_files_of_datumaro(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, theirs: str, ours: str, px: float, tracks: int
) -> None:
    run_library("datumaro", "write", theirs, tmp_path / "out", _json_of(dataset))
    back = read_dataset(tmp_path / "out", target(dataset), FORMATS[ours])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), px)
    # In YOLO there are no ids, and Datumaro leaves them out of CVAT's pictures.
    assert len(list(back.videos[0].tracks())) <= tracks


@pytest.mark.parametrize(("name", "px"), [("coco", 0.001), ("yolo", 0.001), ("voc", 1.01)])
def test_files_of_supervision(dataset: Dataset, run_library: RunLibrary, tmp_path: Path, name: str, px: float) -> None:
    (tmp_path / "out").mkdir()
    run_library("supervision", "write", name, tmp_path / "out", _json_of(dataset))
    switches = {"coordinates": "devkit"} if name == "voc" else {}
    back = read_dataset(tmp_path / "out", target(dataset, **switches), FORMATS[name])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), px)


@pytest.mark.parametrize(
    ("theirs", "ours", "px"), [("coco", "coco", 0.001), ("yolo", "yolo", 0.001), ("voc", "voc", 0.001)]
)
def test_files_of_globox(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, theirs: str, ours: str, px: float
) -> None:
    run_library("globox", "write", theirs, tmp_path / "out", _json_of(dataset))
    back = read_dataset(tmp_path / "out", target(dataset), FORMATS[ours])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), px)


def test_results_of_pycocotools(dataset: Dataset, run_library: RunLibrary, tmp_path: Path) -> None:
    export_dataset(dataset, FORMATS["coco"], tmp_path / "out", ExportOptions(), zipped=False)
    run_library("pycocotools", "read", "coco", tmp_path / "out")
    results = tmp_path / "out" / "results.json"
    assert json.loads(results.read_text())
    back = read_dataset(results, target(dataset), FORMATS["coco"])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.001)
    assert any("counted from 1" in sentence for sentence in back.repaired)
