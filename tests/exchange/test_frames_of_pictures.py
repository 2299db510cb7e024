"""Names of pictures in all formats that list them: the right frames of the right video, told or refused."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.exchange_toys import GTSRB, a_dataset, a_track, a_video, target_of
from tests.exchange.listings import LISTING_FORMATS, found_in, listing, read
from tsr_engine.errors import ImportFormatError, UsageError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

OLD = ("0a1b2c3d4e5f60718293a4b5c6d7e8f3", "1a1b2c3d4e5f60718293a4b5c6d7ea51", "2a1b2c3d4e5f60718293a4b5c6d7eb07")
NEW = ("q9XkT2vLbN7wYc40ZpD1", "q9XkT2vLbN7wYc41ZpD2", "q9XkT2vLbN7wYc42ZpD3")
every_format = pytest.mark.parametrize("format", LISTING_FORMATS)


def _reported(dataset: Dataset) -> str:
    """What was reported, but for the classes, corners and tracks that these files have in common."""
    common = ("no track id", "corners")
    sentences = [sentence for sentence in dataset.repaired if not any(word in sentence for word in common)]
    return " ".join([*sentences, *(f"{item.what}: {item.reason}" for item in dataset.skipped)])


def _refused(path: Path, *words: str, **switches: str) -> None:
    with pytest.raises(ImportFormatError) as error:
        read(path, **switches)
    for word in words:
        assert word in str(error.value)


# ----------------------------------------------------------------------------------------------------- frame numbers


@every_format
@pytest.mark.parametrize("hashes", [OLD, NEW], ids=["old", "new"])
def test_roboflow_numbers_stand_before_its_hash(tmp_path: Path, format: str, hashes: Sequence[str]) -> None:
    names = [f"drive_mp4-{frame:04d}_jpg.rf.{text}" for frame, text in zip((10, 11, 12), hashes, strict=True)]
    back = read(listing(tmp_path, format, names))
    assert found_in(back) == {10: 0, 11: 1, 12: 2}
    assert "counted from 0: Roboflow counts" in _reported(back)


@every_format
@pytest.mark.parametrize("name", ["3f2504e0-4f89-11d3-9a0c-030512345610", OLD[2], "20240501_123011", "drive_640x360"])
def test_hashes_and_dates_are_no_frames(tmp_path: Path, format: str, name: str) -> None:
    _refused(listing(tmp_path, format, [name]), "no frame number. Call it frame_000010.jpg, NAME_000010.jpg")


@every_format
def test_names_that_fit_both_counts_are_refused_and_a_switch_decides(tmp_path: Path, format: str) -> None:
    path = listing(tmp_path, format, ["drive_0010", "drive_0012"])
    _refused(path, "(10 to 12) fit a count from 0 and one from 1", "first_frame=0 or first_frame=1")
    assert found_in(read(path, first_frame="0")) == {10: 0, 12: 1}
    assert found_in(read(path, first_frame="1")) == {9: 0, 11: 1}
    with pytest.raises(UsageError, match="first_frame of .* must be one of auto, 0, 1"):
        read(path, format, first_frame="2")


@every_format
@pytest.mark.parametrize("pattern", ["{:06d}", "frame_{:06d}", "frame_{:04d}", "drive_{:05d}", "img{:03d}"])
def test_a_list_from_1_to_the_number_of_frames_counts_from_1(tmp_path: Path, format: str, pattern: str) -> None:
    back = read(listing(tmp_path, format, [pattern.format(number) for number in range(1, 101)]))
    assert found_in(back) == {frame: frame for frame in range(100)}
    assert "counted from 1: they run from 1 to 100, the number of frames (first_frame)" in _reported(back)


@every_format
def test_a_zero_in_the_list_counts_from_0(tmp_path: Path, format: str) -> None:
    back = read(listing(tmp_path, format, ["drive_0012", "drive_0000"]))
    assert found_in(back) == {12: 0, 0: 1} or found_in(back) == {12: 1, 0: 0}
    assert "counted from 0: 0 is among them" in _reported(back)


@every_format
def test_names_of_cvat_and_ours_need_no_sentence(tmp_path: Path, format: str) -> None:
    for place, pattern in enumerate(("frame_{:06d}", "drive_frame_{:06d}", "1a2b3c4d-frame_{:06d}")):
        back = read(listing(tmp_path / str(place), format, [pattern.format(10)]))
        assert (found_in(back), _reported(back)) == ({10: 0}, "")


@every_format
def test_numbers_beyond_the_video(tmp_path: Path, format: str) -> None:
    rule = ("frame 100 must be in 0 to 99, the frames of drive.mp4", "right video", "from 0 or 1 (first_frame)")
    _refused(listing(tmp_path / "a", format, ["frame_000100", "frame_000098"]), *rule)
    _refused(listing(tmp_path / "b", format, ["drive_0003", "drive_0300"]), "frame 300 must be in 0 to 99")


@every_format
def test_times_of_vott_go_through_the_frame_table(tmp_path: Path, format: str) -> None:
    back = read(listing(tmp_path / "a", format, ["drive.mp4#t=0.4", "drive.mp4#t=0.506667"]))
    assert found_in(back) == {10: 0, 13: 1}
    assert "times in picture names were taken as the nearest frames" in _reported(back)
    _refused(listing(tmp_path / "b", format, ["drive.mp4#t=9.5"]), "the time 9.5 s", "lasts 3.96 s", "right video")


def test_times_of_a_video_of_variable_rate_and_of_one_without_times(tmp_path: Path) -> None:
    path = listing(tmp_path, "yolo", ["drive.mp4#t=0.9"])
    times = np.concatenate([np.arange(10) * 0.1 + 5, np.arange(90) * 0.1 + 8])
    late = replace(a_video(), times=times, constant_rate=False)
    assert found_in(read_dataset(path, ImportTarget(late, GTSRB))) == {9: 0}
    (path / "labels/train/drive.mp4#t=0.9.txt").rename(path / "labels/train/drive.mp4#t=2.txt")
    with pytest.raises(ImportFormatError, match=r"the time 2 s in .* is that of no frame of drive\.mp4"):
        read_dataset(path, ImportTarget(late, GTSRB))
    with pytest.raises(ImportFormatError, match=r"has a time, but the times of drive\.mp4 are not known"):
        read_dataset(path, ImportTarget(replace(a_video(), times=None), GTSRB))


def test_ultralytics_writes_labels_of_a_video_from_1(tmp_path: Path) -> None:
    """I01, I01b: runs/detect/predict/labels/drive_N.txt, with a track id behind the box, and no names of classes."""
    for name, frames in (("begin", range(1, 7)), ("end", range(98, 101))):
        labels = tmp_path / name / "labels"
        labels.mkdir(parents=True)
        for frame in frames:
            (labels / f"drive_{frame}.txt").write_text(f"14 {0.18 + frame / 1000:.4f} 0.27 0.0625 0.1111 1\n")
        back = read(tmp_path / name)
        (track,) = back.videos[0].tracks()
        assert (track.frames + 1).tolist() == list(frames)
        assert track.boxes[0, 0] == pytest.approx((0.18 + frames[0] / 1000) * 640 - 20)
        assert "counted from 1: Ultralytics' save_txt" in _reported(back)
    (tmp_path / "begin" / "labels" / "drive_0.txt").write_text("14 0.2 0.2 0.1 0.1 1\n")
    assert "counted from 0: 0 is among them" in _reported(read(tmp_path / "begin"))


def test_folders_img1_count_from_1(tmp_path: Path) -> None:
    back = read(listing(tmp_path, "coco", ["drive/img1/000010", "drive/img1/000011"]))
    assert found_in(back) == {9: 0, 10: 1}
    assert "counted from 1: pictures in folders img1" in _reported(back)


def test_the_benchmark_counts_from_0(tmp_path: Path) -> None:
    back = read(listing(tmp_path, "gtsdb", ["00010"]))
    assert found_in(back) == {10: 0}
    assert "counted from 0: the benchmark's scenes begin with 00000" in _reported(back)


@every_format
def test_two_pictures_of_one_frame_are_refused(tmp_path: Path, format: str) -> None:
    names = [f"drive_mp4-0010_jpg.rf.{text}" for text in OLD[:2]]
    _refused(listing(tmp_path, format, names), "is frame 10, as", "A frame has one picture", "augmented copy")


@every_format
def test_of_two_numbers_the_rest_of_the_list_must_tell_which_is_the_frame(tmp_path: Path, format: str) -> None:
    _refused(listing(tmp_path / "a", format, ["20240501_123011_000000"]), "two numbers")
    back = read(listing(tmp_path / "b", format, ["20240501_123011_000000", "20240501_123011_000007"]))
    assert sorted(found_in(back)) == [0, 7]
    assert "names '20240501_123011', not drive.mp4" in _reported(back)


# ---------------------------------------------------------------------------------------------------- several videos


@every_format
@pytest.mark.parametrize("pattern", ["{}/frame_000010", "{}_frame_000010", "train/{}/frame_000010"])
def test_of_two_videos_only_the_own_pictures_come_in(tmp_path: Path, format: str, pattern: str) -> None:
    path = listing(tmp_path, format, [pattern.format(name) for name in ("other", "Drive")])
    back = read(path)
    assert sorted(found_in(back)) == [10]
    assert "1 picture: They are of another video than drive.mp4: 'other' (1)." in _reported(back)
    chosen = read(path, video="other")
    assert sorted(found_in(chosen)) == [10]
    assert found_in(chosen) != found_in(back)
    assert "names 'other', not drive.mp4" in _reported(chosen)


@every_format
@pytest.mark.parametrize("pattern", ["{}/frame_000010", "{}_frame_000010"])
def test_of_two_other_videos_none_comes_in_unless_it_is_chosen(tmp_path: Path, format: str, pattern: str) -> None:
    path = listing(tmp_path, format, [pattern.format(name) for name in ("a", "b")])
    _refused(path, "has pictures of 'a' (1), 'b' (1)", "nothing says which are of drive.mp4", "video=NAME")
    _refused(path, "none is called 'c'", video="c")
    assert found_in(read(path, video="a")) == {10: 0}


@every_format
def test_a_single_other_video_comes_in_with_a_sentence(tmp_path: Path, format: str) -> None:
    for place, name in enumerate(("other_frame_000010", "other/frame_000010")):
        back = read(listing(tmp_path / str(place), format, [name]))
        assert found_in(back) == {10: 0}
        assert "names 'other', not drive.mp4" in _reported(back)


@every_format
def test_a_twin_of_the_same_name_is_another_video(tmp_path: Path, format: str) -> None:
    names = ["drive-bbbbbbbb_frame_000010", "drive-aaaaaaaa_frame_000010"]
    back = read(listing(tmp_path / "a", format, names))
    assert sorted(found_in(back)) == [10]
    assert "another video than drive.mp4: 'drive-bbbbbbbb' (1)" in _reported(back)
    _refused(listing(tmp_path / "b", format, names[:1]), "has pictures of 'drive-bbbbbbbb' (1)")


@every_format
def test_pictures_that_name_nothing_are_left_out_beside_those_of_the_video(tmp_path: Path, format: str) -> None:
    """A data set of Roboflow: frames of videos, and pictures from anywhere."""
    names = [f"drive_mp4-0010_jpg.rf.{OLD[0]}", f"75_jpg.rf.{OLD[1]}", f"cat_jpg.rf.{OLD[2]}"]
    back = read(listing(tmp_path, format, names))
    assert sorted(found_in(back)) == [10]
    assert "1 picture: They are of another video" in _reported(back)
    assert "1 picture: Their names have no frame number" in _reported(back)


@every_format
def test_subsets_are_no_videos(tmp_path: Path, format: str) -> None:
    back = read(listing(tmp_path, format, ["train/frame_000010", "val/images/frame_000011", "default/frame_000012"]))
    assert sorted(found_in(back)) == [10, 11, 12]
    assert _reported(back) == ""


@every_format
def test_names_in_two_patterns_can_be_of_two_videos(tmp_path: Path, format: str) -> None:
    _refused(listing(tmp_path, format, ["frame_000010", "img_000011"]), "'frame_' (1), 'img_' (1)", "video=NAME")


@every_format
def test_folders_decide_only_where_names_do_not(tmp_path: Path, format: str) -> None:
    back = read(listing(tmp_path / "a", format, ["batch1/drive_000000", "batch2/drive_000010"]))
    assert sorted(found_in(back)) == [0, 10]
    _refused(listing(tmp_path / "b", format, ["cam1/drive_frame_000010", "cam2/drive_frame_000010"]), "is frame 10, as")
    _refused(listing(tmp_path / "c", format, ["a/drive/frame_000010", "b/drive/frame_000011"]), "'a/drive' (1)")


@pytest.mark.parametrize("format", [name for name in LISTING_FORMATS if name != "gtsdb"])
def test_our_own_exports_come_back_without_a_sentence(tmp_path: Path, format: str) -> None:
    data = a_dataset(a_track("m1", range(95, 100)))
    export_dataset(data, FORMATS[format], tmp_path / "out", zipped=False)
    back = read_dataset(tmp_path / "out", target_of(data))
    assert (back.repaired, back.skipped) == ((), ())


def test_an_export_of_ours_in_the_benchmarks_format_is_known_by_its_manifest(tmp_path: Path) -> None:
    data = a_dataset(a_track("m1", range(95, 100)))
    export_dataset(data, FORMATS["gtsdb"], tmp_path / "out", zipped=False)
    assert _reported(read_dataset(tmp_path / "out", target_of(data))) == ""


# ------------------------------------------------------------------------------------------ folders as tools make them


def test_roboflows_archives_as_they_are(tmp_path: Path) -> None:
    notes = {"README.dataset.txt": "# signs\n", "README.roboflow.txt": "Exported via roboflow.com\n"}
    for kind in ("coco", "yolo", "voc"):
        files = dict(notes)
        for subset, frame in (("train", 10), ("valid", 11), ("test", 12)):
            name = f"drive_mp4-{frame:04d}_jpg.rf.{OLD[frame - 10]}"
            made = listing(tmp_path / kind / subset, kind, [name])
            (path,) = (each for each in made.rglob("*") if each.is_file() and each.name != "data.yaml")
            at = {"coco": "_annotations.coco.json", "yolo": f"labels/{name}.txt", "voc": f"{name}.xml"}[kind]
            files[f"{subset}/{at}"] = path.read_text()
        if kind == "yolo":
            files["data.yaml"] = "names: ['stop']\nnc: 1\n"
        with zipfile.ZipFile(tmp_path / f"{kind}.zip", "w") as archive:
            for name, text in files.items():
                archive.writestr(name, text)
        assert sorted(found_in(read(tmp_path / f"{kind}.zip"))) == [10, 11, 12], kind


def test_files_of_coco_in_one_folder_that_are_called_after_videos(tmp_path: Path) -> None:
    for place, name in enumerate(("instances_other", "instances_drive")):
        made = listing(tmp_path / str(place), "coco", ["frame_000010", "frame_000011"])
        (tmp_path / "in").mkdir(exist_ok=True)
        (made / "instances.json").rename(tmp_path / "in" / f"{name}.json")
    back = read(tmp_path / "in")
    assert found_in(back) == {10: 0, 11: 1}
    assert "'other' (2)" in _reported(back)
    for name in ("instances_other", "instances_drive"):
        (tmp_path / "in" / f"{name}.json").rename(tmp_path / "in" / f"{name.replace('instances_', '')}s.json")
    _refused(tmp_path / "in", "has pictures of 'drives' (2), 'others' (2)")


def test_a_picture_that_several_files_of_coco_list(tmp_path: Path) -> None:
    for name in ("instances_train", "person_keypoints_train"):
        made = listing(tmp_path / name, "coco", ["frame_000010"])
        (tmp_path / "in").mkdir(exist_ok=True)
        (made / "instances.json").rename(tmp_path / "in" / f"{name}.json")
    assert "1 picture is listed by several files" in _reported(read(tmp_path / "in"))


@pytest.mark.parametrize(
    "address",
    [
        "/data/upload/3/1a2b3c4d-frame_000010.jpg",
        "/data/local-files/?d=drive/frame_000010.jpg",
        "https://host/drive/frame_000010.jpg?X-Amz-Signature=ab%2F12",
        "s3://bucket/drive_frame_000010.jpg",
        "C:\\videos\\drive\\frame_000010.jpg",
    ],
)
def test_addresses_of_pictures(tmp_path: Path, address: str) -> None:
    path = listing(tmp_path, "coco", ["x"]) / "instances.json"
    content = json.loads(path.read_text())
    content["images"][0]["file_name"] = address
    path.write_text(json.dumps(content))
    back = read(path)
    assert (found_in(back), _reported(back)) == ({10: 0}, "")


def test_voc_that_names_another_frame_inside_is_told(tmp_path: Path) -> None:
    path = listing(tmp_path, "voc", ["frame_000010", "scene"])
    for name, inside in (("frame_000010", "frame_000012.jpg"), ("scene", "frame_000013.jpg")):
        file = path / "Annotations" / f"{name}.xml"
        file.write_text(file.read_text().replace("<annotation>", f"<annotation><filename>{inside}</filename>"))
    back = read(path)
    assert sorted(found_in(back)) == [10, 13]
    assert (
        "imported by their own name: 1; the first is frame_000010.xml, 'frame_000010.xml' frame_000012.jpg"
        in _reported(back)
    )


@pytest.mark.parametrize(
    "element", ["<folder>{}</folder>", "<folder/><path>/data/{}/x.jpg</path>", "<path>D:\\{}\\x.jpg</path>"]
)
def test_voc_whose_folder_names_a_video(tmp_path: Path, element: str) -> None:
    path = listing(tmp_path, "voc", ["frame_000010", "frame_000011"])
    for name, inside in (("frame_000010", "other"), ("frame_000011", "drive")):
        file = path / "Annotations" / f"{name}.xml"
        file.write_text(file.read_text().replace("<annotation>", f"<annotation>{element.format(inside)}"))
    back = read(path)
    assert sorted(found_in(back)) == [11]
    assert "'other' (1)" in _reported(back)


def test_pictures_of_another_video_may_have_another_size(tmp_path: Path) -> None:
    path = listing(tmp_path, "voc", ["other/frame_000010", "drive/frame_000010"])
    file = path / "Annotations" / "other" / "frame_000010.xml"
    size = "<annotation><size><width>1280</width><height>720</height></size>"
    file.write_text(file.read_text().replace("<annotation>", size))
    assert sorted(found_in(read(path))) == [10]


@pytest.mark.parametrize(
    ("format", "list_file"),
    [("yolo", "train.txt"), ("yolo", "images.txt"), ("voc", "ImageSets/Main/default.txt"), ("gtsdb", "pictures.txt")],
)
def test_a_list_of_all_pictures_tells_where_numbers_begin(tmp_path: Path, format: str, list_file: str) -> None:
    path = listing(tmp_path, format, ["drive_000010"])
    (path / list_file).parent.mkdir(parents=True, exist_ok=True)
    (path / list_file).write_text("".join(f"data/drive_{number:06d}.jpg\n" for number in range(1, 101)))
    back = read(path)
    assert found_in(back) == {9: 0}
    assert "they run from 1 to 100" in _reported(back)
    (path / list_file).write_text("data/drive_000000.jpg\ndata/other_000500.jpg -1\n")
    assert found_in(read(path)) == {10: 0}
    (path / list_file).write_text("data/drive_000300.jpg\n")
    _refused(path, "frame 300 must be in 0 to 99")


def test_fiftyones_folder_of_yolo(tmp_path: Path) -> None:
    """Its YOLOv4 export: labels beside the pictures, and a list of these."""
    data = tmp_path / "data"
    data.mkdir()
    (tmp_path / "obj.names").write_text("stop\nyield\n")
    (tmp_path / "images.txt").write_text("\n".join(f"data/{number:06d}.jpg" for number in range(1, 101)))
    for number in (11, 12):
        (data / f"{number:06d}.txt").write_text(f"0 0.{number} 0.5 0.1 0.1")
    back = read(tmp_path)
    assert sorted(found_in(back)) == [10, 11]
    assert {track.label for track in back.videos[0].tracks()} == {14}


@every_format
def test_what_macos_leaves_behind_is_no_data(tmp_path: Path, format: str) -> None:
    path = listing(tmp_path / "in", format, ["frame_000010", "frame_000011"])
    for file in [each for each in path.rglob("*") if each.is_file()]:
        twin = tmp_path / "__MACOSX" / file.relative_to(tmp_path).with_name(f"._{file.name}")
        for place in (twin, file.with_name(f"._{file.name}")):
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(b"\0\x05\x16\x07\xff")
    (tmp_path / ".DS_Store").write_bytes(b"\xff")
    back = read(tmp_path)
    assert sorted(found_in(back)) == [10, 11]
    assert _reported(back) == ""


def test_a_file_of_classes_with_a_name_of_its_own(tmp_path: Path) -> None:
    path = listing(tmp_path, "yolo", ["frame_000010"])
    (path / "data.yaml").rename(path / "signs.yaml")
    (track,) = read(path).videos[0].tracks()
    assert track.label == 14
    (path / "args.yaml").write_text("task: detect\n")
    assert any("has no class names" in sentence for sentence in read(path).repaired), "two files: nobody guesses"


def test_a_frame_that_the_file_states_against_the_name_is_told(tmp_path: Path) -> None:
    path = listing(tmp_path, "coco", ["frame_000010", "front"]) / "instances.json"
    content = json.loads(path.read_text())
    for image, frame in zip(content["images"], (11, 12), strict=True):
        image["frame"] = frame
    path.write_text(json.dumps(content))
    back = read(path)
    assert found_in(back) == {11: 0, 12: 1}
    assert "got the frame that the file states, not that of their names: 1" in _reported(back)
