"""Images and videos in COCO files of other tools: CocoVID, ids from pandas, hashes, sizes, rotated boxes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.exchange.image_datasets import coco_file, picture_by_frame, read_onto_drive
from tests.exchange.small_datasets import tracks_of
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset

VIDEOS = [{"id": 1, "name": "drive"}, {"id": 2, "name": "train/other"}]


def _read(folder: Path, content: object, **switches: str) -> Dataset:
    path = folder / "cocovid.json"
    path.write_text(json.dumps(content))
    return read_onto_drive(path, "coco", **switches)


def _images(*frames: int, video: object = 1, **more: object) -> list[dict[str, Any]]:
    """Images as mmtracking writes them: names from 000001, ``frame_id`` from 0."""
    return [
        {"file_name": f"drive/img1/{frame + 1:06d}.jpg", "video_id": video, "frame_id": frame, **more}
        for frame in frames
    ]


@pytest.mark.parametrize("frames", [(0, 10, 59), tuple(range(100))], ids=["I13b", "I13"])
def test_frame_ids_and_instances_of_cocovid(tmp_path: Path, frames: tuple[int, ...]) -> None:
    notes = [{"instance_id": 5 + index % 2, "video_id": 1} for index in range(len(frames))]
    back = _read(tmp_path, coco_file(_images(*frames), notes, videos=VIDEOS[:1]))
    assert picture_by_frame(back) == {frame: index for index, frame in enumerate(frames)}
    assert sorted(tracks_of(back)) == ["track5", "track6"]
    assert any("frame ids were counted from 0" in sentence for sentence in back.repaired)


@pytest.mark.parametrize("last", [False, True])
def test_the_list_of_videos_identifies_the_own_video(tmp_path: Path, last: bool) -> None:
    images = [*_images(10, 11, video=2), *_images(10, 12, video=1.0)]
    content = coco_file(images, videos=VIDEOS)
    if not last:
        content = {"videos": content.pop("videos"), **content}
    back = _read(tmp_path, content)
    assert picture_by_frame(back) == {10: 2, 12: 3}
    assert [(item.what, item.reason) for item in back.skipped] == [
        ("2 pictures", "They are of another video than drive.mp4: 'other' (2).")
    ]
    other = _read(tmp_path, content, video="other")
    assert picture_by_frame(other) == {10: 0, 11: 1}
    assert any("names 'other'" in sentence for sentence in other.repaired)


@pytest.mark.parametrize("name", ["annotation_fps", "fps"])
def test_another_frame_rate_is_reported(tmp_path: Path, name: str) -> None:
    """VIAME and DIVE state the rate at which they looked at the video (Kitware/dive#1865)."""
    for rate, reports in ((5, 1), (25.0, 0), (0, 0), ("fast", 0)):
        back = _read(tmp_path, coco_file(_images(10, 11), videos=[{**VIDEOS[0], name: rate}]))
        assert sum("says 5 frames/s, drive.mp4 has 25" in sentence for sentence in back.repaired) == reports


def test_only_other_videos_are_refused(tmp_path: Path) -> None:
    images = [{"file_name": f"{n}.jpg", "video_id": n, "frame_id": 3} for n in (1, 2)]
    videos = [{"id": 1, "name": "a"}, {"id": 2, "name": "b"}]
    with pytest.raises(ImportFormatError, match=r"has pictures of 'a' \(1\), 'b' \(1\); nothing says which"):
        _read(tmp_path, coco_file(images, videos=videos))
    back = _read(tmp_path, coco_file(images[:1], videos=videos))
    assert any("names 'a', not drive.mp4" in sentence for sentence in back.repaired)
    with pytest.raises(ImportFormatError, match=r"image 1: video_id '1' matches no video"):
        _read(tmp_path, coco_file(images, videos=[{"id": 7, "name": "drive"}]))
    with pytest.raises(ImportFormatError, match=r"has pictures of 'video 1' \(1\), 'video 2' \(1\)"):
        _read(tmp_path, coco_file(images))


def test_frame_ids_that_count_from_1(tmp_path: Path) -> None:
    linked = _read(tmp_path, coco_file(_images(10, prev_image_id=-1, next_image_id=2), videos=VIDEOS))
    assert picture_by_frame(linked) == {9: 0}
    assert any("counted from 1: files whose images have prev_image_id" in sentence for sentence in linked.repaired)
    assert picture_by_frame(_read(tmp_path, coco_file(_images(10), videos=VIDEOS), first_frame="1")) == {9: 0}
    with pytest.raises(ImportFormatError, match=r"image 1: frame 100 must be in 0 to 99.*first_frame"):
        _read(tmp_path, coco_file(_images(100), videos=VIDEOS))


def test_frame_ids_equal_to_the_names_may_count_from_1(tmp_path: Path) -> None:
    images = [{"file_name": f"{frame:06d}.jpg", "video_id": 1, "frame_id": frame} for frame in (11, 12)]
    with pytest.raises(ImportFormatError, match=r"image 1: frame ids \(11 to 12\) fit a count from 0 and one from 1"):
        _read(tmp_path, coco_file(images, videos=VIDEOS))
    whole = [{**images[0], "file_name": f"{frame:06d}.jpg", "frame_id": frame} for frame in range(1, 101)]
    assert picture_by_frame(_read(tmp_path, coco_file(whole, videos=VIDEOS))) == {frame: frame for frame in range(100)}
    linked = [{**images[0], "file_name": "drive/img1/000011.jpg", "prev_image_id": -1}]
    assert picture_by_frame(_read(tmp_path, coco_file(linked, videos=VIDEOS))) == {10: 0}, (
        "as ByteTrack's converter writes it"
    )
    images_of_video = [{**images[0], "file_name": "frame_000011.jpg"}]
    assert picture_by_frame(_read(tmp_path, coco_file(images_of_video, videos=VIDEOS))) == {11: 0}


def test_ids_written_by_pandas(tmp_path: Path) -> None:
    """11.0 and "11" are 11 (I24), in a list of results too (I86)."""
    images = [{"id": 11, "file_name": "frame_000010.jpg"}, {"id": "12", "file_name": "frame_000011.jpg"}]
    notes = [
        {"image_id": 11.0, "category_id": 1.0, "track_id": 3.0},
        {"image_id": 12.0, "category_id": "1.0", "track_id": "3"},
    ]
    back = _read(tmp_path, coco_file(images, notes))
    (track,) = tracks_of(back).values()
    assert (track.uid, track.frames.tolist(), track.label) == ("track3", [10, 11], 14)
    (tmp_path / "cocovid.json").write_text(json.dumps({**coco_file(images, notes), "annotations": []}))
    results = [{"image_id": 11.0, "category_id": 1.0, "bbox": [1, 2, 30, 40], "score": 0.25}]
    (tmp_path / "results.json").write_text(json.dumps(results))
    (track,) = tracks_of(read_onto_drive(tmp_path, "coco")).values()
    assert (track.frames.tolist(), track.label) == ([10], 14)
    alone = tmp_path / "alone"
    alone.mkdir()
    (alone / "results.json").write_text(json.dumps([{**results[0], "category_id": 15.0}]))
    (track,) = tracks_of(read_onto_drive(alone / "results.json", "coco")).values()
    assert (track.frames.tolist(), track.label) == ([10], 14)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("image_id", "annotation 1: image_id '11.5' matches no image"),
        ("category_id", "annotation 1: category_id '11.5' matches no category"),
        ("track_id", "annotation 1: track_id must be a whole number. Got '11.5'"),
        ("instance_id", "annotation 1: instance_id must be a whole number. Got '11.5'"),
    ],
)
def test_ids_with_a_fraction_are_refused(tmp_path: Path, key: str, words: str) -> None:
    with pytest.raises(ImportFormatError) as error:
        _read(tmp_path, coco_file([{"file_name": "frame_000010.jpg"}], [{key: 11.5}]))
    assert words in str(error.value)


def test_track_ids_without_a_track(tmp_path: Path) -> None:
    images = [{"file_name": f"frame_{frame:06d}.jpg"} for frame in (10, 50, 90)]
    back = _read(tmp_path, coco_file(images, [{"track_id": "nan"}, {"track_id": None}, {"track_id": -1}]))
    assert len(tracks_of(back)) == 3
    assert any("3 boxes have no track id" in sentence for sentence in back.repaired)


def test_results_with_names_as_image_ids(tmp_path: Path) -> None:
    names = [f"drive_mp4-{frame:04d}_jpg.rf.{'0a1b2c3d' * 4}" for frame in (10, 11)]
    (tmp_path / "results.json").write_text(
        json.dumps([{"image_id": name, "category_id": 15, "bbox": [1, 2, 30, 40], "score": 0.5} for name in names] * 2)
    )
    frames = {
        frame for track in tracks_of(read_onto_drive(tmp_path, "coco")).values() for frame in track.frames.tolist()
    }
    assert frames == {10, 11}


def test_an_ambiguous_image_id_of_results(tmp_path: Path) -> None:
    for name, frame in (("train", 10), ("val", 20)):
        content = {**coco_file([{"file_name": f"frame_{frame:06d}.jpg"}]), "annotations": []}
        (tmp_path / f"instances_{name}.json").write_text(json.dumps(content))
    (tmp_path / "results.json").write_text(json.dumps([{"image_id": 1, "category_id": 1, "bbox": [1, 2, 30, 40]}]))
    with pytest.raises(ImportFormatError, match=r"results.json, result 1: image_id '1' matches no image, or several"):
        read_onto_drive(tmp_path, "coco")


def test_rotated_boxes_become_upright_and_are_reported(tmp_path: Path) -> None:
    """CVAT's COCO has the box before rotation (I32)."""
    notes = [{"bbox": [100, 100, 60, 20], "attributes": {"rotation": 90.0, "track_id": 1, "keyframe": True}}]
    images = [{"file_name": "frame_000010.PNG", "width": 640, "height": 360}]
    back = _read(tmp_path, coco_file(images, notes))
    assert tracks_of(back)["track1"].boxes.tolist() == [pytest.approx([120, 80, 140, 140])]
    assert any(s.startswith("Rotated boxes were replaced by the upright boxes around them: 1") for s in back.repaired)
    notes[0]["attributes"] = {"rotation": "north"}
    with pytest.raises(ImportFormatError, match="annotation 1: rotation must be a finite number"):
        _read(tmp_path, coco_file(images, notes))
    notes[0]["attributes"] = {"rotation": 360.0}
    assert not any("Rotated" in s for s in _read(tmp_path, coco_file(images, notes)).repaired)


def test_sizes_of_images_and_of_their_video(tmp_path: Path) -> None:
    rule = r"image 1: has a picture size of 1280x720 px, drive\.mp4 has 640x360"
    sized = {"width": 1280, "height": 720}
    for content in (
        coco_file(_images(10, **sized), videos=VIDEOS),
        coco_file(_images(10), videos=[{**VIDEOS[0], **sized}]),
    ):
        with pytest.raises(ImportFormatError, match=rule):
            _read(tmp_path, content)
        (track,) = tracks_of(_read(tmp_path, content, size="scale")).values()
        assert track.boxes.tolist() == [[50, 40, 70, 60]]


def test_hashes_of_videos_win_over_names(tmp_path: Path) -> None:
    images = [
        {"file_name": "frame_000010.jpg", "frame": 10, "video": "drive.mp4", "video_sha256": letter * 64}
        for letter in "abc"
    ]
    back = _read(tmp_path, coco_file(images))
    assert picture_by_frame(back) == {10: 0}
    assert "another video than drive.mp4" in back.skipped[0].reason
    back = _read(tmp_path, coco_file(images[1:2]))
    assert any("names another file than drive.mp4 by its hash" in sentence for sentence in back.repaired)
    with pytest.raises(
        ImportFormatError, match=r"has pictures of 'drive\.mp4 \(bbbbbbbb\)' \(1\), 'drive\.mp4 \(cccccccc\)'"
    ):
        _read(tmp_path, coco_file(images[1:]))


def test_regions_to_ignore(tmp_path: Path) -> None:
    """MMDetection leaves out boxes with ``ignore``, a key of the files of Pascal VOC on cocodataset.org."""
    images = [{"file_name": f"frame_{frame:06d}.jpg"} for frame in (10, 20, 30, 40)]
    notes = [{"iscrowd": 1}, {"iscrowd": 0, "ignore": 1}, {"ignore": 0}, {"attributes": {"ignore": True}}]
    back = _read(tmp_path, coco_file(images, notes))
    ignored = {int(t.frames[0]): t.ignore is not None and bool(t.ignore.all()) for t in tracks_of(back).values()}
    assert ignored == {10: True, 20: True, 30: False, 40: True}


def test_relative_boxes_are_refused(tmp_path: Path) -> None:
    """Azure Machine Learning exports COCO in parts of the picture (Azure/MachineLearningNotebooks#1865)."""
    images = [{"file_name": "frame_000010.jpg"}]
    with pytest.raises(ImportFormatError, match=r"annotation 1: the box lies within one pixel, so its edges are rel"):
        _read(tmp_path, coco_file(images, [{"bbox": [0.25, 0.5, 0.1, 0.2]}]))
    ours = {"bbox": [0.25, 0.5, 0.1, 0.2], "attributes": {"uid": "m1", "track_id": 1}}
    assert list(tracks_of(_read(tmp_path, coco_file(images, [ours])))) == ["m1"]


def test_results_keep_their_track_ids(tmp_path: Path) -> None:
    """Results for TAO have ``track_id`` and ``video_id`` (TAO-Dataset/tao, docs/evaluation)."""
    box = {"category_id": 1, "bbox": [10, 20, 30, 30], "score": 0.5, "video_id": 1}
    results = [{**box, "image_id": image, "track_id": track} for image, track in ((1, 7), (2, 8), (3, 7), (4, None))]
    found = _read(tmp_path, results)
    assert {name: track.frames.tolist() for name, track in tracks_of(found).items()} == {
        "track7": [0, 2],
        "track8": [1],
        "box1": [3],
    }
    assert any("1 box has no track id" in sentence for sentence in found.repaired)
