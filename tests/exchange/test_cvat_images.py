"""CVAT for images 1.1: boxes by picture, tracks by an attribute."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.image_datasets import cvat_file, picture_by_frame, read_onto_drive
from tests.exchange.small_datasets import make_dataset, make_track, round_trip, same_tracks, target_of, tracks_of
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.split import make_split

HEAD = '<annotations>\n<image id="0" name="{}" width="640" height="360">\n'
BOX = '<box label="stop" occluded="0" xtl="{}" ytl="1" xbr="9" ybr="9">{}</box>\n'


def _read(tmp_path: Path, content: str, **switches: str) -> Dataset:
    path = tmp_path / "annotations.xml"
    path.write_text(content, encoding="utf-8")
    return read_dataset(path, target_of(make_dataset(), switches=switches), FORMATS["cvat-images"])


def _file(*boxes: str, name: str = "frame_000007.jpg") -> str:
    return HEAD.format(name) + "".join(boxes) + "</image>\n</annotations>"


def test_round_trip(tmp_path: Path) -> None:
    for track, again in same_tracks(make_dataset(), round_trip(make_dataset(), "cvat-images", tmp_path), 0.005):
        assert (again.occluded == track.occluded).all()
        assert np.allclose(again.score, track.score, atol=1e-5, equal_nan=True)


def test_pictures_are_listed_in_order_with_their_subset(tmp_path: Path) -> None:
    data = make_dataset(
        make_track("m1", range(10, 13)), make_track("m2", range(12, 15)), make_track("m3", range(50, 52))
    )
    split = make_split(data, {"train": 0.5, "val": 0.5}, 1)
    export_dataset(data, FORMATS["cvat-images"], tmp_path / "o", ExportOptions(split=split), zipped=False)
    root = ET.parse(tmp_path / "o" / "annotations.xml").getroot()
    images = root.findall("image")
    assert [image.get("id") for image in images] == [str(k) for k in (10, 11, 12, 13, 14, 50, 51)]
    assert [image.get("name") for image in images] == [f"frame_{k:06d}.jpg" for k in (10, 11, 12, 13, 14, 50, 51)]
    assert [len(image.findall("box")) for image in images] == [1, 1, 2, 1, 1, 1, 1]
    side = split["a" * 64, "m1"]
    assert [image.get("subset") == side for image in images] == [True] * 5 + [False] * 2
    assert root.findtext("meta/task/mode") == "annotation"


def test_regions_to_ignore_that_datumaro_writes(tmp_path: Path) -> None:
    mark = '<attribute name="{}">true</attribute>'
    names = ("is_crowd", "ignored", "difficult", "ignore", "dirty")
    found = _read(tmp_path, _file(*(BOX.format(k, mark.format(name)) for k, name in enumerate(names))))
    assert [track.ignore is not None for track in tracks_of(found).values()] == [True] * 4 + [False]


def test_boxes_without_a_name_become_separate_tracks(tmp_path: Path) -> None:
    found = _read(tmp_path, _file(BOX.format(1, ""), BOX.format(2, "")))
    assert [track.frames.tolist() for track in tracks_of(found).values()] == [[7], [7]]


def test_tags_and_other_shapes_are_skipped(tmp_path: Path) -> None:
    found = _read(tmp_path, _file('<tag label="stop"/>', "<polygon/>", BOX.format(1, "")))
    assert [item.what for item in found.skipped] == ["annotations.xml: 1 tags", "annotations.xml: 1 shapes"]
    assert len(tracks_of(found)) == 1


def test_pictures_of_another_size(tmp_path: Path) -> None:
    content = _file(BOX.format(1, "")).replace("640", "320").replace("360", "180")
    with pytest.raises(ImportFormatError, match="line 2: has a picture size of 320x180"):
        _read(tmp_path, content)
    found = _read(tmp_path, content, size="scale")
    assert next(iter(tracks_of(found).values())).boxes.tolist() == [[2, 2, 18, 18]]


def test_a_file_of_datumaro(tmp_path: Path) -> None:
    ended = BOX.format(1, "").replace("<box", '<box outside="1" keyframe="1"')
    found = _read(tmp_path, _file(BOX.format(2, ""), ended).replace(' width="640" height="360"', ""))
    assert [track.boxes.tolist() for track in tracks_of(found).values()] == [[[2, 1, 9, 9]]]


UID = '<attribute name="uid">a</attribute>'


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        (_file(BOX.format("nan", "")), "line 3: box .* finite"),
        (_file(BOX.format(9, "")), "line 3: box .* positive width"),
        (_file(BOX.format("x", "")), "line 3: xtl of <box> must be a number"),
        (_file(BOX.format(1, UID), BOX.format(2, UID)), "line 4: track 'a' has a second, different box in frame 7"),
        (_file(BOX.format(1, ""), name="frame_000100.jpg"), "line 2: frame 100 must be in 0 to 99"),
        (_file(BOX.format(1, ""), name="front.jpg"), "line 2: the picture 'front.jpg' has no frame number"),
        (_file(BOX.format(1, "").replace('"0"', '"no"')), "line 3: occluded of <box> must be 0 or 1"),
        (_file(BOX.format(1, '<attribute name="score">x</attribute>')), "line 3: the attribute score"),
        ("<annotations>\n<track/></annotations>", "line 2: has <track> elements: it is CVAT for video"),
        (
            HEAD.format("frame_000001").replace(' width="640"', "") + "<box/></image></annotations>",
            "<image> must have width",
        ),
        ('<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><annotations/>', "line 1: a DOCTYPE"),
    ],
)
def test_refusals(tmp_path: Path, content: str, rule: str) -> None:
    with pytest.raises(ImportFormatError, match=f"annotations.xml.*{rule}"):
        _read(tmp_path, content)


TASK = "<task><id>{}</id><name>{}</name>{}</task>"


def test_a_project_gives_the_tasks_of_the_video(tmp_path: Path) -> None:
    """Each task has its frame_000010; only ``task_id`` differs (I83)."""
    path = tmp_path / "annotations.xml"
    images = [
        f'name="frame_0000{frame}" task_id="{task}" width="640" height="360"' for task in (1, 2) for frame in (10, 11)
    ]
    path.write_text(cvat_file(images, "<project><id>1</id></project>"))
    with pytest.raises(
        ImportFormatError, match=r"has pictures of 'task 1' \(2\), 'task 2' \(2\); nothing says which.*video="
    ):
        read_onto_drive(path)
    back = read_onto_drive(path, video="task 2")
    assert picture_by_frame(back) == {10: 2, 11: 3}
    assert any("names 'task 2'" in sentence for sentence in back.repaired)
    for tasks in (
        TASK.format(1, "other", "") + TASK.format(2, "Drive", ""),
        TASK.format(1, "a", "<source>other.mp4</source>") + TASK.format(2, "b", "<source>drive.mp4</source>"),
    ):
        path.write_text(cvat_file(images, f"<project><id>7</id><name>p</name><tasks>{tasks}</tasks></project>"))
        back = read_onto_drive(path)
        assert picture_by_frame(back) == {10: 2, 11: 3}
        assert "another video than drive.mp4" in back.skipped[0].reason


def test_names_in_a_project_contain_the_frames_of_earlier_tasks(tmp_path: Path) -> None:
    """CVAT adds the frames of the tasks before to the ids and names of pictures."""
    task = "<source>{}.mp4</source><size>{}</size><start_frame>0</start_frame><frame_filter/>"
    tasks = TASK.format(1, "a", task.format("other", 40)) + TASK.format(2, "b", task.format("drive", 100))
    picture = '<image id="{1}" name="frame_{1:06d}" task_id="{0}" width="640" height="360">{2}</image>'
    pictures = "".join(
        picture.format(task_id, frame, BOX.format(1, "")) for task_id, frame in ((1, 5), (2, 40), (2, 139))
    )
    meta = f"<meta><project><id>7</id><name>p</name><tasks>{tasks}</tasks></project></meta>"
    found = _read(tmp_path, f"<annotations>{meta}{pictures}</annotations>")
    assert [track.frames.tolist() for track in tracks_of(found).values()] == [[0], [99]]


def test_a_task_of_another_video_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "annotations.xml"
    path.write_text(cvat_file(['name="frame_000010"'], TASK.format(1, "x", "<source>other.mp4</source>")))
    back = read_onto_drive(path)
    assert picture_by_frame(back) == {10: 0}
    assert any("names 'other.mp4', not drive.mp4" in sentence for sentence in back.repaired)
    path.write_text(cvat_file(['name="frame_000010"'], TASK.format(1, "any name", "")))
    assert read_onto_drive(path).repaired == ()


def test_two_pictures_of_one_frame_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "annotations.xml"
    path.write_text(cvat_file(['name="frame_000010"'] * 2))
    with pytest.raises(
        ImportFormatError, match=r"annotations\.xml, line 4: is frame 10, as annotations\.xml, line 3 is"
    ):
        read_onto_drive(path)


@pytest.mark.parametrize("meta", ["<task>{}</task>", "<job>{}</job>", "{}"])
def test_a_size_in_the_head_is_checked(tmp_path: Path, meta: str) -> None:
    size = meta.format("<original_size><width>1280</width><height>720</height></original_size>")
    (tmp_path / "annotations.xml").write_text(cvat_file(['name="frame_000010"'], size))
    with pytest.raises(ImportFormatError, match="has a picture size of 1280x720 px"):
        read_onto_drive(tmp_path)
    assert next(iter(tracks_of(read_onto_drive(tmp_path, size="scale")).values())).boxes.tolist() == [[50, 40, 70, 60]]
    own = 'name="frame_000010" width="640" height="360"'
    (tmp_path / "annotations.xml").write_text(cvat_file([own], size))
    assert picture_by_frame(read_onto_drive(tmp_path)) == {10: 0}, "a picture's own size comes first"
