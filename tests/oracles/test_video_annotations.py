"""We read files about a video from other libraries: right frames, boxes, tracks and classes, or a sentence."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from tests.oracles import fiftyone_layouts
from tests.oracles.conftest import FRAMES, Box, RunLibrary, assert_same_boxes, boxes_of, target
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.labels import label_name
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

TRACKS = [[3, 4, 5, 6, 9, 10], [5, 6, 7, 8]]


def _json_of(dataset: Dataset) -> dict[str, Any]:
    """The video and all boxes, with the numbers of their tracks."""
    boxes = [
        [frame, label_name(dataset.labels, track.label), *box, {"track_id": number}]
        for number, track in enumerate(dataset.videos[0].tracks(), start=1)
        for frame, box in zip(track.frames.tolist(), track.boxes.tolist(), strict=True)
    ]
    return {"video": str(dataset.videos[0].path), "boxes": boxes}


def _rows(dataset: Dataset) -> list[fiftyone_layouts.Row]:
    return [((*box[:6],), box[6]["track_id"]) for box in _json_of(dataset)["boxes"]]


def _frames_of(back: Dataset) -> list[list[int]]:
    return sorted(track.frames.tolist() for track in back.videos[0].tracks())


def _reported(back: Dataset) -> str:
    return " ".join([*back.repaired, *(f"{left.what} {left.reason}" for left in back.skipped)])


@pytest.mark.parametrize("kind", ["csv", "json"])
@pytest.mark.parametrize("column", ["frame_index", "frame_number", "frame"])
def test_sinks_of_supervision(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, kind: str, column: str
) -> None:
    path = tmp_path / f"rows.{kind}"
    run_library("supervision", "sink", f"{kind} {column} names", path, _json_of(dataset))
    back = read_dataset(path, target(dataset))
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.001)
    assert _frames_of(back) == TRACKS
    assert {score for track in back.videos[0].tracks() for score in track.score.tolist()} == {0.75}


@pytest.mark.parametrize("kind", ["csv", "json"])
def test_sinks_of_supervision_with_class_numbers_only(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, kind: str
) -> None:
    path = tmp_path / f"rows.{kind}"
    run_library("supervision", "sink", f"{kind} frame_index", path, _json_of(dataset))
    back = read_dataset(path, target(dataset))
    # The numbers are the model's; reading them as the tool's must be reported.
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.001)
    assert "class" in _reported(back)
    assert "number" in _reported(back)


@pytest.mark.parametrize("asked", ["txt", "conf", "track", "conf track"])
def test_label_files_of_ultralytics(dataset: Dataset, run_library: RunLibrary, tmp_path: Path, asked: str) -> None:
    found = run_library("ultralytics", "predict", asked, tmp_path, _json_of(dataset))
    # It counts from 1.
    assert {int(re.findall(r"\d+", name)[-1]) for name in found["files"]} == {frame + 1 for frame in range(3, 11)}
    back = read_dataset(tmp_path / "predict", target(dataset), FORMATS["yolo"])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.001)
    assert "from 1" in _reported(back)
    if "track" in asked:
        assert _frames_of(back) == TRACKS
    if "conf" in asked:
        assert {score for track in back.videos[0].tracks() for score in track.score.tolist()} == {0.75}


@pytest.mark.parametrize("kind", ["json", "summary", "csv", "df"])
def test_tables_of_ultralytics(dataset: Dataset, run_library: RunLibrary, tmp_path: Path, kind: str) -> None:
    path = tmp_path / {"csv": "rows.csv", "df": "rows.csv"}.get(kind, "rows.json")
    run_library("ultralytics", "results", kind, path, _json_of(dataset))
    back = read_dataset(path, target(dataset))
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.001)
    assert _frames_of(back) == TRACKS


def test_a_list_of_results_of_ultralytics_has_one_entry_a_frame(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path
) -> None:
    run_library("ultralytics", "results", "list", tmp_path / "rows.json", _json_of(dataset))
    back = read_dataset(tmp_path / "rows.json", target(dataset), FORMATS["tracks-json"])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.001)
    assert _frames_of(back) == TRACKS


@pytest.mark.parametrize("kind", ["dataset", "list"])
def test_results_that_pycocotools_loaded(dataset: Dataset, run_library: RunLibrary, tmp_path: Path, kind: str) -> None:
    export_dataset(dataset, FORMATS["coco"], tmp_path / "out", ExportOptions(pictures="all"), zipped=False)
    run_library("pycocotools", "results", kind, tmp_path / "out")
    back = read_dataset(tmp_path / "out" / "loaded.json", target(dataset), FORMATS["coco"])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.001)
    if kind == "list":
        assert "counted from 1" in _reported(back)


@pytest.mark.parametrize("kind", ["json", "predictions", "frames"])
def test_tasks_of_label_studio(dataset: Dataset, run_library: RunLibrary, tmp_path: Path, kind: str) -> None:
    run_library("label_studio_sdk", "task", kind, tmp_path / "tasks.json", _json_of(dataset))
    back = read_dataset(tmp_path / "tasks.json", target(dataset))
    assert_same_boxes(boxes_of(dataset), boxes_of(back), 1e-6)
    assert _frames_of(back) == TRACKS
    assert "other" not in _reported(back)


@pytest.mark.parametrize(("kind", "ours", "px"), [("COCO", "coco", 1e-6), ("YOLO", "yolo", 1e-6), ("VOC", "voc", 1.01)])
def test_pictures_of_label_studio(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, kind: str, ours: str, px: float
) -> None:
    run_library("label_studio_sdk", "images", kind, tmp_path / "out", _json_of(dataset))
    # Its VOC has edges from 0 and truncates corner and size to whole pixels, without a note.
    given = {"coordinates": "cvat"} if ours == "voc" else {}
    back = read_dataset(tmp_path / "out", target(dataset, **given), FORMATS[ours])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), px)


@pytest.mark.parametrize(("kind", "name"), [("JSON_MIN", "result.json"), ("CSV", "result.csv"), ("TSV", "result.tsv")])
def test_label_studio_exports_without_ids_are_refused(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path, kind: str, name: str
) -> None:
    run_library("label_studio_sdk", "task", kind, tmp_path / name, _json_of(dataset))
    with pytest.raises(ImportFormatError, match=r"Export as JSON, not"):
        read_dataset(tmp_path / name, target(dataset))


def test_regions_of_the_sdk_last_from_key_frame_to_key_frame(
    dataset: Dataset, run_library: RunLibrary, tmp_path: Path
) -> None:
    run_library("label_studio_sdk", "label", "json", tmp_path / "tasks.json", _json_of(dataset))
    back = read_dataset(tmp_path / "tasks.json", target(dataset))
    # A value of the SDK cannot say that a region ends; without ``enabled`` it stays to the end of the video.
    assert _frames_of(back) == [list(range(3, FRAMES)), list(range(5, FRAMES))]
    found = {(box[0], box[1]): box for box in boxes_of(back)}
    assert_same_boxes(boxes_of(dataset), [found[box[0], box[1]] for box in boxes_of(dataset)], 1e-6)


# FiftyOne needs no environment: fiftyone_layouts.py renders its layouts.


@pytest.mark.parametrize("keys", [False, True])
def test_tracks_of_fiftyone(dataset: Dataset, tmp_path: Path, keys: bool) -> None:
    fiftyone_layouts.cvat_video(_rows(dataset), tmp_path / "labels" / "drive.xml", keys)
    for path in (tmp_path / "labels" / "drive.xml", tmp_path):
        back = read_dataset(path, target(dataset), FORMATS["cvat-video"])
        assert_same_boxes(boxes_of(dataset), boxes_of(back), 0.51)
        assert _frames_of(back) == TRACKS


@pytest.mark.parametrize(
    ("layout", "ours", "px"),
    [("coco", "coco", 1e-6), ("yolov5", "yolo", 1e-4), ("yolov4", "yolo", 1e-4), ("cvat_images", "cvat-images", 0.51)],
)
def test_frames_of_fiftyone_count_from_one(dataset: Dataset, tmp_path: Path, layout: str, ours: str, px: float) -> None:
    getattr(fiftyone_layouts, layout)(_rows(dataset), tmp_path / "out")
    if layout == "yolov5":
        # Pictures without boxes have no label file, so the first number is unknown.
        with pytest.raises(ImportFormatError, match="first_frame"):
            read_dataset(tmp_path / "out", target(dataset), FORMATS[ours])
    given = {"first_frame": "1"} if layout == "yolov5" else {}
    back = read_dataset(tmp_path / "out", target(dataset, **given), FORMATS[ours])
    assert_same_boxes(boxes_of(dataset), boxes_of(back), px)
    assert given or "from 1" in _reported(back)


def test_the_expected_tracks_match_the_data_set(dataset: Dataset) -> None:
    def plain(box: Box) -> int:
        return box[0]

    assert sorted(plain(box) for box in boxes_of(dataset)) == sorted(frame for track in TRACKS for frame in track)
