"""Datumaro JSON: written files, round trips, and refusals with file and place."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.exchange.small_datasets import (
    CLASS_NAMES,
    GTSRB,
    make_dataset,
    make_track,
    make_video,
    round_trip,
    same_tracks,
    target_of,
    tracks_of,
    with_value,
)
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.split import make_split
from tsr_engine.exchange.thinning import key_frames

_FACTS = {"occluded": False, "track_id": 7, "keyframe": True, "outside": False}
_BOX = {
    "id": 0,
    "type": "bbox",
    "attributes": _FACTS,
    "group": 0,
    "label_id": 0,
    "z_order": 0,
    "bbox": [10, 10, 10, 12],
}
_IMAGE = {"path": "frame_000010.jpg", "size": [360, 640]}
SAMPLE: dict[str, Any] = {
    "dm_format_version": "1.0",
    "media_type": 2,
    "infos": {},
    "categories": {
        "label": {"label_groups": [], "labels": [{"name": "stop", "parent": "", "attributes": []}], "attributes": []},
        "mask": {"colormap": []},
    },
    "items": [{"id": "frame_000010", "annotations": [_BOX], "attr": {"frame": 10}, "image": _IMAGE}],
}


def _read(tmp_path: Path, content: Any, **switches: str) -> Dataset:
    path = tmp_path / "default.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return read_dataset(path, target_of(make_dataset(), switches=switches), FORMATS["datumaro"])


BOX = "items/0/annotations/0"


def test_the_sample_of_the_documentation(tmp_path: Path) -> None:
    found = _read(tmp_path, SAMPLE)
    track = tracks_of(found)["datumaro-7"]
    assert (track.frames.tolist(), track.boxes.tolist(), track.label) == ([10], [[10, 10, 20, 22]], 14)
    assert (found.skipped, found.repaired) == ((), ())


def test_written_file(tmp_path: Path) -> None:
    data = make_dataset(make_track("m1", range(10, 13), boxes=[(1, 2, 11, 22), (2, 2, 12, 22), (3, 2, 13, 22)]))
    export_dataset(data, FORMATS["datumaro"], tmp_path / "o", zipped=False)
    content = json.loads((tmp_path / "o" / "annotations" / "default.json").read_text())
    assert [label["name"] for label in content["categories"]["label"]["labels"]] == list(CLASS_NAMES)
    assert [item["id"] for item in content["items"]] == ["frame_000010", "frame_000011", "frame_000012"]
    item = content["items"][0]
    assert item["image"] == {"path": "frame_000010.jpg", "size": [360, 640]}
    assert item["attr"]["frame"] == 10
    box = item["annotations"][0]
    assert (box["bbox"], box["label_id"], box["type"]) == ([1, 2, 10, 20], 14, "bbox")
    assert box["attributes"]["track_id"] == 1
    assert [i["annotations"][0]["attributes"]["keyframe"] for i in content["items"]] == [True, False, True]


def test_round_trip(tmp_path: Path) -> None:
    for track, again in same_tracks(make_dataset(), round_trip(make_dataset(), "datumaro", tmp_path), 1e-4):
        assert (again.occluded == track.occluded).all()
        assert (again.key == key_frames(track, 0.5, rounding=0.00005)).all()
        assert np.allclose(again.score, track.score, atol=1e-7, equal_nan=True)


def test_a_file_for_each_subset(tmp_path: Path) -> None:
    data = make_dataset(*(make_track(f"m{k}", range(20 * k, 20 * k + 10)) for k in range(4)))
    split = make_split(data, {"train": 0.5, "val": 0.5}, 1)
    export_dataset(data, FORMATS["datumaro"], tmp_path / "o", ExportOptions(split=split), zipped=False)
    for side in ("train", "val"):
        content = json.loads((tmp_path / "o" / "annotations" / f"{side}.json").read_text())
        uids = {box["attributes"]["uid"] for item in content["items"] for box in item["annotations"]}
        assert uids == {uid for (_, uid), on in split.items() if on == side}
    assert sorted(tracks_of(read_dataset(tmp_path / "o", target_of(data)))) == ["m0", "m1", "m2", "m3"]


def test_track_numbers_of_two_videos_differ(tmp_path: Path) -> None:
    videos = (
        make_video([make_track("m1"), make_track("m2")]),
        make_video([make_track("m1")], name="b.mp4", sha="b" * 64),
    )
    export_dataset(Dataset(GTSRB, videos), FORMATS["datumaro"], tmp_path / "o", zipped=False)
    content = json.loads((tmp_path / "o" / "annotations" / "default.json").read_text())
    numbers = {box["attributes"]["track_id"] for item in content["items"] for box in item["annotations"]}
    assert numbers == {1, 2, 3}
    assert len({item["id"] for item in content["items"]}) == len(content["items"]) == 60


def _items(*names_and_frames: tuple[str, int]) -> dict[str, Any]:
    boxes = [{**_BOX, "attributes": {}}]
    return {
        **SAMPLE,
        "items": [{"id": name, "annotations": boxes, "attr": {"frame": frame}} for name, frame in names_and_frames],
    }


def test_positions_in_a_list_are_not_frames(tmp_path: Path) -> None:
    """CVAT's tasks of pictures number the pictures, whose names have the frames."""
    found = _read(tmp_path, _items(("drive_000000", 0), ("drive_000010", 1), ("drive_000020", 2)))
    assert [track.frames.tolist() for track in tracks_of(found).values()] == [[0], [10], [20]]
    assert any("only the position in a list" in sentence and ": 3;" in sentence for sentence in found.repaired)
    found = _read(tmp_path, _items(("frame_000040", 0), ("frame_000041", 1)))
    assert [track.frames.tolist() for track in tracks_of(found).values()] == [[40], [41]]


@pytest.mark.parametrize(
    "names",
    [("drive_000110", "drive_000120"), ("sign_20", "sign_9"), ("drive_4", "drive_5"), ("a1", "b9")],
    ids=["names of a longer video", "names in another order", "names from 1", "names without a sequence"],
)
def test_other_numbers_in_names_do_not_replace_frames(tmp_path: Path, names: tuple[str, str]) -> None:
    found = _read(tmp_path, _items((names[0], 3), (names[1], 4)))
    assert [track.frames.tolist() for track in tracks_of(found).values()] == [[3], [4]]


def test_scores_as_text(tmp_path: Path) -> None:
    """CVAT writes attributes of the kind text as texts, also an empty default."""
    (track,) = tracks_of(_read(tmp_path, with_value(SAMPLE, f"{BOX}/attributes/score", "0.93"))).values()
    assert track.score.tolist() == [0.93]
    (track,) = tracks_of(_read(tmp_path, with_value(SAMPLE, f"{BOX}/attributes/score", ""))).values()
    assert np.isnan(track.score).all()


def test_end_marks_are_not_boxes(tmp_path: Path) -> None:
    content = copy.deepcopy(SAMPLE)
    last = copy.deepcopy(content["items"][0])
    last["id"], last["attr"]["frame"] = "frame_000015", 15
    last["annotations"][0]["attributes"]["outside"] = True
    content["items"].append(last)
    assert tracks_of(_read(tmp_path, content))["datumaro-7"].frames.tolist() == [10]
    sparse = _read(tmp_path, content, interpolate="yes")
    assert tracks_of(sparse)["datumaro-7"].frames.tolist() == [10, 11, 12, 13, 14]


def test_frames_of_videos_are_those_of_the_media(tmp_path: Path) -> None:
    """Datumaro 1 writes ``video_frame`` in place of ``image`` for its format ``video_frames``."""
    content = copy.deepcopy(SAMPLE)
    (item,) = content["items"]
    del item["attr"], item["image"]
    content["items"] = [
        {**item, "id": name, "video_frame": {"video_path": f"/data/{video}.mp4", "frame_index": frame}}
        for name, video, frame in (("000000", "drive", 30), ("000001", "drive", 60), ("000002", "other", 61))
    ]
    found = _read(tmp_path, content)
    assert tracks_of(found)["datumaro-7"].frames.tolist() == [30, 60]
    assert "'other.mp4' (1)" in found.skipped[0].reason


@pytest.mark.parametrize("name", ["is_crowd", "ignored", "difficult"])
def test_regions_to_ignore_of_other_formats(tmp_path: Path, name: str) -> None:
    """Datumaro's readers of COCO, MOT and Pascal VOC keep such marks as these attributes."""
    for value in (True, False):
        found = _read(tmp_path, with_value(SAMPLE, f"{BOX}/attributes", {"track_id": 7, name: value}))
        ignore = tracks_of(found)["datumaro-7"].ignore
        assert (ignore is not None and bool(ignore.all())) == value
        assert found.skipped == ()
    ours = _read(tmp_path, with_value(SAMPLE, f"{BOX}/attributes", {"uid": "m1", name: True}))
    assert tracks_of(ours)["m1"].ignore is None


def test_other_annotations_are_skipped(tmp_path: Path) -> None:
    found = _read(tmp_path, with_value(SAMPLE, f"{BOX}/type", "polygon"))
    assert not tracks_of(found)
    assert found.skipped[0].what == "1 annotations"


def test_boxes_without_a_track_become_separate_tracks(tmp_path: Path) -> None:
    content = with_value(SAMPLE, f"{BOX}/attributes", {})
    content["items"][0]["annotations"].append(copy.deepcopy(content["items"][0]["annotations"][0]))
    assert len(tracks_of(_read(tmp_path, content))) == 2


def test_pictures_of_another_size(tmp_path: Path) -> None:
    content = with_value(SAMPLE, "items/0/image/size", [180, 320])
    with pytest.raises(ImportFormatError, match="item 1: has a picture size of 320x180"):
        _read(tmp_path, content)
    assert tracks_of(_read(tmp_path, content, size="scale"))["datumaro-7"].boxes.tolist() == [[20, 20, 40, 44]]


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        ("{", "line 1: is not JSON"),
        ("[]", "must be an object with a list of items"),
        (with_value(SAMPLE, "items", {}), "must be an object with a list of items"),
        (with_value(SAMPLE, "categories", {}), "has no categories.label.labels"),
        (with_value(SAMPLE, "items/0", 7), "item 1: must be an object"),
        (with_value(SAMPLE, "items/0/annotations", 7), "item 1: must be an object with a list"),
        (with_value(SAMPLE, BOX, 7), "item 1, box 1: must be an object"),
        (with_value(SAMPLE, "items/0/attr/frame", 100), "item 1: frame 100 must be in 0 to 99"),
        (with_value(SAMPLE, "items/0/attr/frame", -1), "item 1: frame -1"),
        (with_value(SAMPLE, "items/0/attr/frame", [1]), "item 1: frame"),
        (with_value(SAMPLE, "items/0/image/size", "big"), "item 1: image.size must be"),
        (with_value(SAMPLE, "items/0/image/size", [10**400, 640]), "item 1: image.size must be"),
        (with_value(SAMPLE, f"{BOX}/label_id", 1), "item 1, box 1: label_id 1 must be 0 to 0"),
        (with_value(SAMPLE, f"{BOX}/label_id", None), "item 1, box 1: label_id None"),
        (with_value(SAMPLE, f"{BOX}/bbox", [1, 2, 3]), "item 1, box 1: bbox must be four numbers"),
        (with_value(SAMPLE, f"{BOX}/bbox", [1, 2, "3", 4]), "item 1, box 1: bbox must be four numbers"),
        (with_value(SAMPLE, f"{BOX}/bbox", [True, 2, 3, 4]), "item 1, box 1: bbox must be four numbers"),
        (with_value(SAMPLE, f"{BOX}/bbox", [1, 2, -3, 4]), "item 1, box 1: box .* positive width"),
        (with_value(SAMPLE, f"{BOX}/bbox", [1, 2, 10**400, 4]), "item 1, box 1: bbox is too large"),
        (with_value(SAMPLE, f"{BOX}/attributes/score", "high"), "item 1, box 1: score must be a finite number"),
        (with_value(SAMPLE, f"{BOX}/attributes/score", 1.5), "item 1, box 1: score 1.5"),
        (json.dumps(SAMPLE).replace("[10, 10, 10, 12]", "[NaN, 1, 1, 1]"), "item 1, box 1: bbox must be four numbers"),
        (json.dumps(SAMPLE).replace("[10, 10, 10, 12]", "[1e999, 1, 1, 1]"), "item 1, box 1: box .* finite"),
    ],
)
def test_refusals(tmp_path: Path, content: Any, rule: str) -> None:
    with pytest.raises(ImportFormatError, match=f"default.json.*{rule}"):
        _read(tmp_path, content)


def test_a_picture_without_a_frame_number(tmp_path: Path) -> None:
    content = with_value(SAMPLE, "items/0/id", "front")
    assert tracks_of(_read(tmp_path, content))["datumaro-7"].frames.tolist() == [10]
    del content["items"][0]["attr"]
    assert tracks_of(_read(tmp_path, content))["datumaro-7"].frames.tolist() == [10], "by the path of its image"
    content["items"][0]["image"]["path"] = "front.jpg"
    with pytest.raises(ImportFormatError, match="item 1: the picture 'front' has no frame number"):
        _read(tmp_path, content)


def test_two_different_boxes_of_a_track_in_one_frame(tmp_path: Path) -> None:
    content = copy.deepcopy(SAMPLE)
    again = copy.deepcopy(content["items"][0]["annotations"][0])
    again["bbox"] = [11, 10, 10, 12]
    content["items"][0]["annotations"].append(again)
    with pytest.raises(ImportFormatError, match="track 'datumaro-7' has a second, different box in frame 10"):
        _read(tmp_path, content)


def test_rotated_boxes_become_upright_and_are_reported(tmp_path: Path) -> None:
    content = with_value(SAMPLE, f"{BOX}/attributes/rotation", 90.0)
    content["items"][0]["annotations"][0]["bbox"] = [100, 100, 60, 20]
    found = _read(tmp_path, content)
    assert tracks_of(found)["datumaro-7"].boxes.tolist() == [pytest.approx([120, 80, 140, 140])]
    assert any(sentence.startswith("Rotated boxes were replaced") for sentence in found.repaired)
    with pytest.raises(ImportFormatError, match="item 1, box 1: rotation must be a finite number"):
        _read(tmp_path, with_value(SAMPLE, f"{BOX}/attributes/rotation", [1]))


@pytest.mark.parametrize("track", [7.0, "7", "7.0"])
def test_ids_written_by_pandas(tmp_path: Path, track: object) -> None:
    content = with_value(SAMPLE, f"{BOX}/attributes/track_id", track)
    content["items"][0]["annotations"][0]["label_id"] = 0.0
    content["items"][0]["attr"]["frame"] = 10.0
    assert tracks_of(_read(tmp_path, content))["datumaro-7"].frames.tolist() == [10]
    with pytest.raises(ImportFormatError, match="item 1, box 1: track_id must be a whole number"):
        _read(tmp_path, with_value(SAMPLE, f"{BOX}/attributes/track_id", 11.5))


def test_files_of_older_versions_and_of_cvat_are_recognised(tmp_path: Path) -> None:
    content = {key: value for key, value in SAMPLE.items() if key not in ("dm_format_version", "media_type", "infos")}
    path = tmp_path / "default.json"
    path.write_text(json.dumps({"info": {}, **content}))
    assert list(tracks_of(read_dataset(path, target_of(make_dataset())))) == ["datumaro-7"]
