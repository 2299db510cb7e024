"""Label Studio video JSON: frames from 1, percent, and only videos of constant rate."""

from __future__ import annotations

import copy
import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.exchange.label_studio_files import REGION, SAMPLE, first_frame, read_tasks
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
from tsr_engine.errors import ExportError, ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.split import make_split
from tsr_engine.exchange.thinning import key_frames


def test_the_sample_of_the_documentation(tmp_path: Path) -> None:
    found = read_tasks(tmp_path, SAMPLE)
    track = tracks_of(found)["7f3a"]
    assert track.frames.tolist() == list(range(10, 41))
    assert np.allclose(track.boxes[0], [64, 72, 96, 108])
    assert np.allclose(track.boxes[15], [160, 72, 192, 108])
    assert np.flatnonzero(track.key).tolist() == [0, 30]
    assert (found.skipped, found.repaired) == ((), ())


def test_a_region_that_stays_enabled_lasts_to_the_end(tmp_path: Path) -> None:
    content = with_value(SAMPLE, f"{REGION}/value/sequence/1/enabled", True)
    assert tracks_of(read_tasks(tmp_path, content))["7f3a"].frames.tolist() == list(range(10, 100))


def test_written_file(tmp_path: Path) -> None:
    boxes = [(64, 36, 128, 72)] * 3 + [(320, 180, 640, 360)]
    track = make_track("m1", [0, 1, 2, 50], boxes=boxes, score=np.array([0.5, 0.7, np.nan, np.nan]))
    reported = export_dataset(make_dataset(track), FORMATS["label-studio"], tmp_path / "o", zipped=False)
    task = json.loads((tmp_path / "o" / "tasks.json").read_text())[0]
    assert (task["data"]["video"], task["data"]["fps"]) == ("drive.mp4", 25.0)
    region = task["predictions"][0]["result"][0]
    assert (region["id"], region["type"], region["origin"]) == ("m1", "videorectangle", "prediction")
    assert region["score"] == 0.6
    assert (region["value"]["framesCount"], region["value"]["duration"]) == (100, 4.0)
    assert region["value"]["sequence"] == [
        {"frame": 1, "time": 0.04, "x": 10, "y": 10, "width": 10, "height": 10, "rotation": 0, "enabled": True},
        {"frame": 3, "time": 0.12, "x": 10, "y": 10, "width": 10, "height": 10, "rotation": 0, "enabled": False},
        {"frame": 51, "time": 2.04, "x": 50, "y": 50, "width": 50, "height": 50, "rotation": 0, "enabled": False},
    ]
    assert reported.skipped[0]["what"] == "2 scores"
    config = ET.parse(tmp_path / "o" / "label_config.xml").getroot()
    assert [label.get("value") for label in config.iter("Label")] == list(CLASS_NAMES)
    video = config.find("Video")
    assert video is not None
    assert video.get("framerate") == "$fps"


@pytest.mark.parametrize("thin_px", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("kind", ["predictions", "annotations"])
def test_round_trip(tmp_path: Path, thin_px: float, kind: str) -> None:
    back = round_trip(make_dataset(), "label-studio", tmp_path, thin_px=thin_px, switches={"as": kind})
    for track, again in same_tracks(make_dataset(), back, max(thin_px, 1e-4)):
        assert (again.key == key_frames(track, thin_px, rounding=1e-4)).all()


def test_a_file_for_each_subset(tmp_path: Path) -> None:
    data = make_dataset(*(make_track(f"m{k}", range(20 * k, 20 * k + 10)) for k in range(4)))
    split = make_split(data, {"train": 0.5, "val": 0.5}, 1)
    export_dataset(data, FORMATS["label-studio"], tmp_path / "o", ExportOptions(split=split), zipped=False)
    for side in ("train", "val"):
        task = json.loads((tmp_path / "o" / f"tasks_{side}.json").read_text())[0]
        uids = {region["id"] for region in task["predictions"][0]["result"]}
        assert uids == {uid for (_, uid), on in split.items() if on == side}
    assert sorted(tracks_of(read_dataset(tmp_path / "o", target_of(data)))) == ["m0", "m1", "m2", "m3"]


def test_a_variable_frame_rate_is_refused_both_ways(tmp_path: Path) -> None:
    for change in ({"constant_rate": False}, {"rate": None}):
        data = make_dataset()
        data = replace(data, videos=(replace(data.videos[0], **change),))  # type: ignore[arg-type]
        with pytest.raises(ExportError, match=r"^drive.mp4 has a variable frame rate\. .* choose CVAT for video\.$"):
            export_dataset(data, FORMATS["label-studio"], tmp_path / "o", zipped=False)
        assert not (tmp_path / "o").exists()
        with pytest.raises(ImportFormatError, match="tasks.json: counts frames by time, but drive.mp4 has a variable"):
            read_tasks(tmp_path, SAMPLE, data)


def test_frames_counted_at_another_rate(tmp_path: Path) -> None:
    with pytest.raises(ImportFormatError, match="region 1: was drawn on 96 frames, drive.mp4 has 100"):
        read_tasks(tmp_path, with_value(SAMPLE, f"{REGION}/value/framesCount", 96))
    assert tracks_of(read_tasks(tmp_path, with_value(SAMPLE, f"{REGION}/value/framesCount", 101)))


def test_frames_of_a_longer_sound_track(tmp_path: Path) -> None:
    def content(count: int, duration: float) -> object:
        counted = with_value(SAMPLE, f"{REGION}/value/framesCount", count)
        return with_value(counted, f"{REGION}/value/duration", duration)

    found = read_tasks(tmp_path, content(103, 4.096))
    assert tracks_of(found)
    assert any("a sound track that is longer than the pictures: 1" in sentence for sentence in found.repaired)
    for count, duration in ((103, 4.29), (97, 3.88), (150, 6.0)):
        with pytest.raises(ImportFormatError, match=f"was drawn on {count} frames"):
            read_tasks(tmp_path, content(count, duration))


@pytest.mark.parametrize(
    ("place", "name"),
    [
        (f"{REGION}/value/framesCount", "framesCount"),
        (f"{REGION}/value/sequence/0/time", "time"),
        ("0/data/fps", "fps"),
    ],
)
def test_numbers_that_no_float_holds(tmp_path: Path, place: str, name: str) -> None:
    with pytest.raises(ImportFormatError, match=f": {name} is too large"):
        read_tasks(tmp_path, with_value(SAMPLE, place, 10**400))
    counted = with_value(SAMPLE, f"{REGION}/value/framesCount", 103)
    with pytest.raises(ImportFormatError, match="duration is too large"):
        read_tasks(tmp_path, with_value(counted, f"{REGION}/value/duration", 10**400))


def test_annotations_win_over_predictions_in_the_right_task(tmp_path: Path) -> None:
    content = copy.deepcopy(SAMPLE)
    region = copy.deepcopy(content[0]["predictions"][0]["result"][0])
    region["meta"]["text"] = ["uid=human", "looks bent"]
    content[0]["annotations"] = [{"was_cancelled": True, "result": []}, {"result": [region, {"type": "choices"}]}]
    content.insert(0, {"data": {"video": "other.mp4"}, "annotations": [{"result": [region]}]})
    found = read_tasks(tmp_path, content)
    assert list(tracks_of(found)) == ["human"]
    assert tracks_of(found)["human"].notes == ((10, "looks bent"),)
    assert len(found.skipped) == 3
    foreign = Dataset(GTSRB, (make_video(name="elsewhere.mp4"),))
    with pytest.raises(ImportFormatError, match=r"has 2 tasks, none about elsewhere\.mp4"):
        read_tasks(tmp_path, content, foreign)


MIN = [{"video": "/data/upload/1/1a2b3c4d-drive.mp4", "id": 1, "annotator": 1, "annotation_id": 1, "lead_time": 1.0,
        "box": [{"framesCount": 100, "labels": ["stop"], "sequence": [{"frame": 11, "x": 1, "y": 1, "width": 5,
                 "height": 5, "enabled": True}]}]}]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("min.json", json.dumps(MIN)),
        ("min.json", json.dumps([{key: value for key, value in MIN[0].items() if key != "annotator"}])),
        ("out.csv", "video,id,box,annotator,annotation_id,created_at,updated_at,lead_time\ndrive.mp4,1,[],1,1,a,b,2\n"),
        ("out.tsv", "video\tid\tbox\tannotator\tannotation_id\tlead_time\ndrive.mp4\t1\t[]\t1\t1\t2\n"),
    ],
)
def test_reduced_exports_are_recognised(tmp_path: Path, name: str, content: str) -> None:
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(ImportFormatError, match=rf"{name}.*Export as JSON, not JSON-MIN"):
        read_dataset(path, target_of(make_dataset()))


def _keys(*keys: tuple[int, float | None]) -> list[dict[str, Any]]:
    """The sample with these frames and times."""
    content = copy.deepcopy(SAMPLE)
    box = {"x": 10, "y": 20, "width": 5, "height": 10, "enabled": True}
    value = content[0]["predictions"][0]["result"][0]["value"]
    value["sequence"] = [{"frame": frame, **box} | ({} if time is None else {"time": time}) for frame, time in keys]
    value["sequence"][-1]["enabled"] = False
    del value["framesCount"], value["duration"]
    return content


@pytest.mark.parametrize(
    ("keys", "reported"),
    [
        (((11, 0.44), (41, 1.64)), ()),
        (((11, None), (41, None)), ()),
        (
            ((11, 0.4), (41, 1.6)),
            ("tasks.json, task 1: key frames were taken by their number, from 1; their times begin at 0.",),
        ),
    ],
)
def test_both_conventions_of_times_are_read(
    tmp_path: Path, keys: tuple[tuple[int, float | None], ...], reported: tuple[str, ...]
) -> None:
    found = read_tasks(tmp_path, _keys(*keys))
    assert (first_frame(found), found.repaired) == (10, reported)


def test_times_that_contradict_the_frame_numbers(tmp_path: Path) -> None:
    at_24 = tuple((frame, frame / 24) for frame in (41, 61, 81))
    with pytest.raises(ImportFormatError, match=r"key frame 1: frame 41 is at 1\.708.* drive\.mp4 has 25 frames/s"):
        read_tasks(tmp_path, _keys(*at_24))
    with pytest.raises(ImportFormatError, match="key frame 1: frame 13 is at 0.4 s"):
        read_tasks(tmp_path, _keys((13, 0.4), (43, 1.6)))
    reported = read_tasks(tmp_path, _keys((11, 0.44), (20, 0.1), (41, 1.64))).repaired
    assert reported == ("Key frames were taken by their number; their time is that of another: 1; the first is "
    "tasks.json, "
                    "task 1, region 1, key frame 2.",)  # fmt: skip
    reported = read_tasks(tmp_path, with_value(SAMPLE, "0/data/fps", 30.0)).repaired
    assert [text.startswith("tasks.json, task 1: says 30 frames/s, drive.mp4 has 25.") for text in reported] == [True]


def test_labels_in_other_places(tmp_path: Path) -> None:
    content = with_value(SAMPLE, f"{REGION}/value/labels", ...)
    assert "Regions have no label: 1" in read_tasks(tmp_path, content).repaired[0]
    results = content[0]["predictions"][0]["result"]
    results.append({"id": "t7", "type": "labels", "from_name": "videoLabels", "value": {"labels": ["stop"]}})
    found = read_tasks(tmp_path, content)
    assert (tracks_of(found)["7f3a"].label, found.repaired, found.skipped) == (14, (), ())
    results[1]["value"]["labels"] = ["stop", "yield"]
    assert "Regions of several labels have the first one: 1" in read_tasks(tmp_path, content).repaired[0]


def test_a_region_without_an_end(tmp_path: Path) -> None:
    content = copy.deepcopy(SAMPLE)
    for key in content[0]["predictions"][0]["result"][0]["value"]["sequence"]:
        del key["enabled"]
    found = read_tasks(tmp_path, content)
    assert tracks_of(found)["7f3a"].frames[-1] == 99
    assert "Regions without enabled do not state their end" in found.repaired[0]


def test_an_empty_annotation_before_predictions_is_reported(tmp_path: Path) -> None:
    content = copy.deepcopy(SAMPLE)
    content[0]["annotations"] = [{"result": []}]
    found = read_tasks(tmp_path, content)
    assert tracks_of(found) == {}
    assert "it has no video rectangles, and others have" in found.skipped[0].reason


def test_rotated_boxes_become_upright(tmp_path: Path) -> None:
    content = with_value(SAMPLE, f"{REGION}/value/sequence/0/rotation", 90)
    found = read_tasks(tmp_path, content)
    # Clockwise about its upper left corner: 32 x 36 px become 36 px to the left and 32 px down.
    assert np.allclose(tracks_of(found)["7f3a"].boxes[0], [64 - 36, 72, 64, 72 + 32])
    assert found.repaired[0].startswith("Rotated boxes were replaced by the upright boxes around them: 1;")


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        ("[", "line 1: is not JSON"),
        ("7", "must be a list of tasks"),
        ([7], "must be a list of tasks"),
        ([{"data": {}}], "task 1: has neither annotations nor predictions"),
        (with_value(SAMPLE, REGION, 7), "region 1: must be an object"),
        (with_value(SAMPLE, f"{REGION}/value", ...), "region 1: must have a value with a sequence"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1", 7), "region 1, key frame 2: must be an object"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/frame", 0), "key frame 2: frame 0 must be in 1 to 100"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/frame", 101), "key frame 2: frame 101 must be in 1 to 100"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/frame", "x"), "key frame 2: frame 'x'"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/frame", ...), "key frame 2: frame ''"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/x", ...), "key frame 2: x must be a number"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/x", "1"), "key frame 2: x must be a number"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/x", 10**400), "key frame 2: x is too large"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/width", -1), "key frame 2: box .* positive width"),
        (with_value(SAMPLE, f"{REGION}/value/sequence/1/frame", 11), "has a second, different box in frame 10"),
        (json.dumps(SAMPLE).replace('"x": 40', '"x": NaN'), "key frame 2: x must be a number"),
        (json.dumps(SAMPLE).replace('"x": 40', '"x": 1e999'), "key frame 2: box .* finite"),
    ],
)
def test_refusals(tmp_path: Path, content: Any, rule: str) -> None:
    with pytest.raises(ImportFormatError, match=f"tasks.json.*{rule}"):
        read_tasks(tmp_path, content)


def test_regions_of_one_name_stay_separate(tmp_path: Path) -> None:
    content = copy.deepcopy(SAMPLE)
    content[0]["predictions"][0]["result"] *= 2
    found = read_tasks(tmp_path, content)
    assert list(tracks_of(found)) == ["7f3a", "7f3a-2"]
    assert "7f3a is now 7f3a-2" in found.repaired[0]


def test_boxes_between_rotated_key_frames_have_their_own_angle(tmp_path: Path) -> None:
    """Label Studio interpolates the corner and, the shorter way, the angle (``interpolateProp``)."""
    content = with_value(SAMPLE, f"{REGION}/value/sequence/0/rotation", 350)
    content = with_value(content, f"{REGION}/value/sequence/1/rotation", 80)
    track = tracks_of(read_tasks(tmp_path, content))["7f3a"]
    # In the middle the box of 32 x 36 px is turned by 35 degrees about its corner at (160, 72).
    cos, sin = np.cos(np.radians(35)), np.sin(np.radians(35))
    assert np.allclose(track.boxes[15], [160 - 36 * sin, 72, 160 + 32 * cos, 72 + 32 * sin + 36 * cos])
    assert np.flatnonzero(track.key).tolist() == [0, 30]
