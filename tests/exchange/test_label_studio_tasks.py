"""Tasks of Label Studio: the one about the import's video is found by address, name or choice."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from tests.exchange.label_studio_files import SAMPLE, first_frame, read_tasks
from tests.exchange.small_datasets import make_dataset, target_of, tracks_of, with_value
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.load import read_dataset


def _tasks_about(*addresses: str, **more: Any) -> list[dict[str, Any]]:
    """One task per address; the boxes of each begin one frame later than those of the previous one."""
    tasks = []
    for index, address in enumerate(addresses):
        task = copy.deepcopy(SAMPLE[0])
        task["data"]["video"] = address
        for key in task["predictions"][0]["result"][0]["value"]["sequence"]:
            key["frame"] += index
            key["time"] = key["frame"] / 25
        tasks.append({"id": index + 1, **task, **more})
    return tasks


OTHER = "/data/upload/1/55aa3c4d-other.mp4"


@pytest.mark.parametrize(
    "address",
    [
        "drive.mp4",
        "videos/drive.mp4",
        "C:\\videos\\drive.mp4",
        "/data/local-files/?d=drive.mp4",
        "/data/local-files/?d=dir%2Fsub/drive.mp4",
        "/data/local-files/?d=dir#1/drive.mp4",
        "https://bucket.s3.amazonaws.com/a/drive.mp4?X-Amz-Signature=abc&X-Amz-Expires=1",
        "https://storage.googleapis.com/b/drive.mp4?GoogleAccessId=a%40b&Signature=x%2B",
        "https://account.blob.core.windows.net/c/drive.mp4?sv=2020&sig=a%3D",
        "s3://bucket/drive.mp4",
        "/tasks/7/presign/?fileuri=czM6Ly9idWNrZXQvZHJpdmUubXA0",
        "/data/upload/3/1a2b3c4d-drive.mp4",
        "/data/upload/3/20240101-drive.mp4",
        "https://host/get?file=drive.mp4",
    ],
)
def test_the_task_is_found_by_its_address(tmp_path: Path, address: str) -> None:
    found = read_tasks(tmp_path, _tasks_about(OTHER, address))
    assert first_frame(found) == 11
    assert found.repaired == ()
    assert [(item.what, "other.mp4" in item.reason) for item in found.skipped] == [("tasks.json: 1 task", True)]


@pytest.mark.parametrize(
    ("video", "address"),
    [
        ("100% drive #1 ü.mp4", "/data/upload/1/1a2b3c4d-100_drive_1_ü.mp4"),
        ("100% drive #1 u\u0308.mp4", "/data/upload/1/1a2b3c4d-100_drive_1_ü.mp4"),
        ("100% drive #1 ü.mp4", "/data/upload/1/1a2b3c4d-100_drive_1_u.mp4"),
        ("100% drive #1 ü.mp4", "/data/local-files/?d=100%25%20drive%20%231%20%C3%BC.mp4"),
        ("100% drive #1 ü.mp4", "s3://bucket/100% drive #1 u\u0308.mp4"),
        ("100% drive #1 ü.mp4", "/data/local-files/?d=100% drive #1 ü.mp4"),
        ("my (2) drive.mp4", "/data/upload/1/1a2b3c4d-my_2_drive.mp4"),
    ],
)
def test_the_task_is_found_by_a_name_changed_by_label_studio(tmp_path: Path, video: str, address: str) -> None:
    found = read_tasks(tmp_path, _tasks_about(OTHER, address), make_dataset(name=video))
    assert (first_frame(found), found.repaired) == (11, ())


@pytest.mark.parametrize(
    "name",
    ["rear-drive.mp4", "my-drive.mp4", "1a2b3c4d-rear-drive.mp4", "1a2b3c4-drive.mp4", "20240101-drive.mp4",
     "1a2b3c4d-1a2b3c4d-drive.mp4", "drive/other.mp4", "other.mp4?x=drive.mp4"],
)  # fmt: skip
def test_a_task_of_another_video_is_not_used(tmp_path: Path, name: str) -> None:
    with pytest.raises(ImportFormatError, match=r"none about drive\.mp4: 1 \(.*\), 2 \(other\.mp4\).* task=ID"):
        read_tasks(tmp_path, _tasks_about(name, OTHER))


def test_a_single_task_of_another_video_is_imported_and_reported(tmp_path: Path) -> None:
    found = read_tasks(tmp_path, _tasks_about("/data/upload/1/1a2b3c4d-other.mp4"))
    assert first_frame(found) == 10
    assert found.repaired == ("tasks.json: names other.mp4. It was imported onto drive.mp4.",)


def test_the_upload_name_is_used_without_an_address(tmp_path: Path) -> None:
    tasks = [*_tasks_about(OTHER), *_tasks_about("https://host/v/17", file_upload="1a2b3c4d-drive.mp4")]
    tasks[1]["predictions"][0]["result"][0]["value"]["sequence"][0] |= {"frame": 13, "time": 0.52}
    assert first_frame(read_tasks(tmp_path, tasks)) == 12


@pytest.mark.parametrize(("task", "first"), [("2", 11), ("other.mp4", 10), ("rear-drive", 11)])
def test_the_task_can_be_chosen(tmp_path: Path, task: str, first: int) -> None:
    path = tmp_path / "tasks.json"
    path.write_text(json.dumps(_tasks_about(OTHER, "rear-drive.mp4")))
    found = read_dataset(path, target_of(make_dataset(), switches={"task": task}))
    assert first_frame(found) == first
    assert "names " in found.repaired[0]
    with pytest.raises(ImportFormatError, match=r"2 tasks, none that is or names '7'.*other\.mp4"):
        read_dataset(path, target_of(make_dataset(), switches={"task": "7"}))


def test_two_matching_tasks_are_not_mixed(tmp_path: Path) -> None:
    with pytest.raises(ImportFormatError, match=r"has 2 tasks that fit drive\.mp4: 1 .*, 2 .*task=ID"):
        read_tasks(tmp_path, _tasks_about("a/drive.mp4", "b/drive.mp4"))
    # The full name wins over the name without its suffix.
    assert first_frame(read_tasks(tmp_path, _tasks_about("drive.avi", "drive.mp4"))) == 11


def test_only_regions_of_the_imported_video_are_read(tmp_path: Path) -> None:
    (task,) = _tasks_about("drive.mp4")
    task["data"]["rear"] = "rear.mp4"
    (region,) = task["predictions"][0]["result"]
    task["predictions"][0]["result"].append({**copy.deepcopy(region), "id": "r", "to_name": "rear"})
    found = read_tasks(tmp_path, [task])
    assert list(tracks_of(found)) == ["7f3a"]
    assert found.skipped[0].reason == "It is drawn on rear.mp4."
    task["predictions"][0]["result"].pop(0)
    assert "names rear.mp4" in read_tasks(tmp_path, [task]).repaired[0]


@pytest.mark.parametrize("value", [None, ["drive.mp4"], ...])
def test_a_task_without_a_video_is_reported(tmp_path: Path, value: Any) -> None:
    found = read_tasks(tmp_path, with_value(SAMPLE, "0/data/video", value))
    assert found.repaired == (
        "tasks.json, task 1: does not say which video it is about. It was imported onto drive.mp4.",
    )


def test_a_skipped_task_reports_that_its_prediction_is_taken(tmp_path: Path) -> None:
    """Label Studio keeps a skipped task as an annotation with ``was_cancelled`` (its guide, task_format)."""
    (task,) = _tasks_about("drive.mp4")
    task["annotations"] = [{"was_cancelled": True, "result": []}]
    found = read_tasks(tmp_path, [task])
    assert list(tracks_of(found)) == ["7f3a"]
    assert found.repaired == ("tasks.json, task 1: was skipped in Label Studio, so its prediction was imported.",)
    task["annotations"].append({"was_cancelled": False, "result": []})
    assert not tracks_of(read_tasks(tmp_path, [task]))
