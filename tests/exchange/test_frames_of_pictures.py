"""Picture names in all formats that list them: the right frames of the right video, reported or refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.image_datasets import (
    IMAGE_FORMATS,
    assert_refused,
    import_report,
    picture_by_frame,
    read_onto_drive,
    write_dataset,
    write_text,
)
from tests.exchange.small_datasets import GTSRB, make_dataset, make_track, make_video, target_of
from tsr_engine.errors import ImportFormatError, UsageError
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

OLD = ("0a1b2c3d4e5f60718293a4b5c6d7e8f3", "1a1b2c3d4e5f60718293a4b5c6d7ea51", "2a1b2c3d4e5f60718293a4b5c6d7eb07")
NEW = ("q9XkT2vLbN7wYc40ZpD1", "q9XkT2vLbN7wYc41ZpD2", "q9XkT2vLbN7wYc42ZpD3")
every_format = pytest.mark.parametrize("format", IMAGE_FORMATS)


# ----------------------------------------------------------------------------------------------------- frame numbers


@every_format
@pytest.mark.parametrize("hashes", [OLD, NEW], ids=["old", "new"])
def test_roboflow_numbers_precede_the_hash(tmp_path: Path, format: str, hashes: Sequence[str]) -> None:
    names = [f"drive_mp4-{frame:04d}_jpg.rf.{text}" for frame, text in zip((10, 11, 12), hashes, strict=True)]
    back = read_onto_drive(write_dataset(tmp_path, format, names))
    assert picture_by_frame(back) == {10: 0, 11: 1, 12: 2}
    assert "counted from 0: Roboflow counts" in import_report(back)


@every_format
@pytest.mark.parametrize("name", ["3f2504e0-4f89-11d3-9a0c-030512345610", OLD[2], "20240501_123011", "drive_640x360"])
def test_hashes_and_dates_are_not_frame_numbers(tmp_path: Path, format: str, name: str) -> None:
    assert_refused(
        write_dataset(tmp_path, format, [name]), None, "no frame number. Call it frame_000010.jpg, NAME_000010.jpg"
    )


@every_format
def test_names_that_fit_both_counts_are_refused_unless_an_option_decides(tmp_path: Path, format: str) -> None:
    path = write_dataset(tmp_path, format, ["drive_0010", "drive_0012"])
    assert_refused(path, None, "(10 to 12) fit a count from 0 and one from 1", "first_frame=0 or first_frame=1")
    assert picture_by_frame(read_onto_drive(path, first_frame="0")) == {10: 0, 12: 1}
    assert picture_by_frame(read_onto_drive(path, first_frame="1")) == {9: 0, 11: 1}
    with pytest.raises(UsageError, match="first_frame of .* must be one of auto, 0, 1"):
        read_onto_drive(path, format, first_frame="2")


@every_format
@pytest.mark.parametrize("pattern", ["{:06d}", "frame_{:06d}", "frame_{:04d}", "drive_{:05d}", "img{:03d}"])
def test_a_list_from_1_to_the_frame_count_counts_from_1(tmp_path: Path, format: str, pattern: str) -> None:
    back = read_onto_drive(write_dataset(tmp_path, format, [pattern.format(number) for number in range(1, 101)]))
    assert picture_by_frame(back) == {frame: frame for frame in range(100)}
    assert "counted from 1: they run from 1 to 100, the number of frames (first_frame)" in import_report(back)


@every_format
def test_a_zero_in_the_list_counts_from_0(tmp_path: Path, format: str) -> None:
    back = read_onto_drive(write_dataset(tmp_path, format, ["drive_0012", "drive_0000"]))
    assert picture_by_frame(back) == {12: 0, 0: 1} or picture_by_frame(back) == {12: 1, 0: 0}
    assert "counted from 0: 0 is among them" in import_report(back)


@every_format
def test_names_of_cvat_and_ours_are_read_without_a_report(tmp_path: Path, format: str) -> None:
    for index, pattern in enumerate(("frame_{:06d}", "drive_frame_{:06d}", "1a2b3c4d-frame_{:06d}")):
        back = read_onto_drive(write_dataset(tmp_path / str(index), format, [pattern.format(10)]))
        assert (picture_by_frame(back), import_report(back)) == ({10: 0}, "")


@every_format
def test_numbers_beyond_the_video(tmp_path: Path, format: str) -> None:
    rule = ("frame 100 must be in 0 to 99, the frames of drive.mp4", "right video", "from 0 or 1 (first_frame)")
    assert_refused(write_dataset(tmp_path / "a", format, ["frame_000100", "frame_000098"]), None, *rule)
    assert_refused(
        write_dataset(tmp_path / "b", format, ["drive_0003", "drive_0300"]), None, "frame 300 must be in 0 to 99"
    )


@every_format
def test_times_of_vott_use_the_frame_table(tmp_path: Path, format: str) -> None:
    back = read_onto_drive(write_dataset(tmp_path / "a", format, ["drive.mp4#t=0.4", "drive.mp4#t=0.506667"]))
    assert picture_by_frame(back) == {10: 0, 13: 1}
    assert "times in picture names were taken as the nearest frames" in import_report(back)
    assert_refused(
        write_dataset(tmp_path / "b", format, ["drive.mp4#t=9.5"]),
        None,
        "the time 9.5 s",
        "lasts 3.96 s",
        "right video",
    )


def test_times_of_a_video_of_variable_rate_and_of_one_without_times(tmp_path: Path) -> None:
    path = write_dataset(tmp_path, "yolo", ["drive.mp4#t=0.9"])
    times = np.concatenate([np.arange(10) * 0.1 + 5, np.arange(90) * 0.1 + 8])
    late = replace(make_video(), times=times, constant_rate=False)
    assert picture_by_frame(read_dataset(path, ImportTarget(late, GTSRB))) == {9: 0}
    (path / "labels/train/drive.mp4#t=0.9.txt").rename(path / "labels/train/drive.mp4#t=2.txt")
    with pytest.raises(ImportFormatError, match=r"the time 2 s in .* is that of no frame of drive\.mp4"):
        read_dataset(path, ImportTarget(late, GTSRB))
    with pytest.raises(ImportFormatError, match=r"has a time, but the times of drive\.mp4 are not known"):
        read_dataset(path, ImportTarget(replace(make_video(), times=None), GTSRB))


def test_ultralytics_writes_labels_of_a_video_from_1(tmp_path: Path) -> None:
    """Files drive_N.txt, with a track id behind the box and without class names (findings I01, I01b)."""
    for name, frames in (("begin", range(1, 7)), ("end", range(98, 101))):
        labels = tmp_path / name / "labels"
        labels.mkdir(parents=True)
        for frame in frames:
            (labels / f"drive_{frame}.txt").write_text(f"14 {0.18 + frame / 1000:.4f} 0.27 0.0625 0.1111 1\n")
        back = read_onto_drive(tmp_path / name)
        (track,) = back.videos[0].tracks()
        assert (track.frames + 1).tolist() == list(frames)
        assert track.boxes[0, 0] == pytest.approx((0.18 + frames[0] / 1000) * 640 - 20)
        assert "counted from 1: Ultralytics' save_txt" in import_report(back)
    (tmp_path / "begin" / "labels" / "drive_0.txt").write_text("14 0.2 0.2 0.1 0.1 1\n")
    assert "counted from 0: 0 is among them" in import_report(read_onto_drive(tmp_path / "begin"))


def test_the_file_of_a_loop_over_frames_is_refused(tmp_path: Path) -> None:
    """``model.track(frame, save_txt=True)`` appends each frame to ``labels/image0.txt`` (ultralytics#22256)."""
    rows = "".join(f"0 0.{k} 0.5 0.1 0.1\n" for k in range(1, 9))
    write_text(tmp_path, "labels/image0.txt", rows)
    assert_refused(tmp_path, "yolo", "labels/image0.txt", "without their frames", "Run it on the video file")
    write_text(tmp_path, "labels/image1.txt", rows)
    assert read_onto_drive(tmp_path, "yolo").videos


def test_folders_img1_count_from_1(tmp_path: Path) -> None:
    back = read_onto_drive(write_dataset(tmp_path, "coco", ["drive/img1/000010", "drive/img1/000011"]))
    assert picture_by_frame(back) == {9: 0, 10: 1}
    assert "counted from 1: pictures in folders img1" in import_report(back)


def test_the_benchmark_counts_from_0(tmp_path: Path) -> None:
    back = read_onto_drive(write_dataset(tmp_path, "gtsdb", ["00010"]))
    assert picture_by_frame(back) == {10: 0}
    assert "counted from 0: the benchmark's scenes begin with 00000" in import_report(back)


@every_format
def test_two_pictures_of_one_frame_are_refused(tmp_path: Path, format: str) -> None:
    names = [f"drive_mp4-0010_jpg.rf.{text}" for text in OLD[:2]]
    assert_refused(
        write_dataset(tmp_path, format, names), None, "is frame 10, as", "A frame has one picture", "augmented copy"
    )


@every_format
def test_the_list_decides_which_of_two_numbers_is_the_frame(tmp_path: Path, format: str) -> None:
    assert_refused(write_dataset(tmp_path / "a", format, ["20240501_123011_000000"]), None, "two numbers")
    back = read_onto_drive(write_dataset(tmp_path / "b", format, ["20240501_123011_000000", "20240501_123011_000007"]))
    assert sorted(picture_by_frame(back)) == [0, 7]
    assert "names '20240501_123011', not drive.mp4" in import_report(back)


# ---------------------------------------------------------------------------------------------------- several videos


@every_format
@pytest.mark.parametrize("pattern", ["{}/frame_000010", "{}_frame_000010", "train/{}/frame_000010"])
def test_only_pictures_of_this_video_are_imported(tmp_path: Path, format: str, pattern: str) -> None:
    path = write_dataset(tmp_path, format, [pattern.format(name) for name in ("other", "Drive")])
    back = read_onto_drive(path)
    assert sorted(picture_by_frame(back)) == [10]
    assert "1 picture: They are of another video than drive.mp4: 'other' (1)." in import_report(back)
    chosen = read_onto_drive(path, video="other")
    assert sorted(picture_by_frame(chosen)) == [10]
    assert picture_by_frame(chosen) != picture_by_frame(back)
    assert "names 'other', not drive.mp4" in import_report(chosen)


@every_format
@pytest.mark.parametrize("pattern", ["{}/frame_000010", "{}_frame_000010"])
def test_two_other_videos_are_imported_only_by_choice(tmp_path: Path, format: str, pattern: str) -> None:
    path = write_dataset(tmp_path, format, [pattern.format(name) for name in ("a", "b")])
    assert_refused(path, None, "has pictures of 'a' (1), 'b' (1)", "nothing says which are of drive.mp4", "video=NAME")
    assert_refused(path, None, "none is called 'c'", video="c")
    assert picture_by_frame(read_onto_drive(path, video="a")) == {10: 0}


@every_format
def test_a_single_other_video_is_imported_and_reported(tmp_path: Path, format: str) -> None:
    for index, name in enumerate(("other_frame_000010", "other/frame_000010")):
        back = read_onto_drive(write_dataset(tmp_path / str(index), format, [name]))
        assert picture_by_frame(back) == {10: 0}
        assert "names 'other', not drive.mp4" in import_report(back)


@every_format
def test_another_hash_behind_the_same_name_is_another_video(tmp_path: Path, format: str) -> None:
    names = ["drive-bbbbbbbb_frame_000010", "drive-aaaaaaaa_frame_000010"]
    back = read_onto_drive(write_dataset(tmp_path / "a", format, names))
    assert sorted(picture_by_frame(back)) == [10]
    assert "another video than drive.mp4: 'drive-bbbbbbbb' (1)" in import_report(back)
    assert_refused(write_dataset(tmp_path / "b", format, names[:1]), None, "has pictures of 'drive-bbbbbbbb' (1)")


@every_format
def test_pictures_without_a_video_are_left_out_beside_those_of_the_video(tmp_path: Path, format: str) -> None:
    """A data set of Roboflow with frames of videos and other pictures."""
    names = [f"drive_mp4-0010_jpg.rf.{OLD[0]}", f"75_jpg.rf.{OLD[1]}", f"cat_jpg.rf.{OLD[2]}"]
    back = read_onto_drive(write_dataset(tmp_path, format, names))
    assert sorted(picture_by_frame(back)) == [10]
    assert "1 picture: They are of another video" in import_report(back)
    assert "1 picture: Their names have no frame number" in import_report(back)


@every_format
def test_subsets_are_not_videos(tmp_path: Path, format: str) -> None:
    back = read_onto_drive(
        write_dataset(tmp_path, format, ["train/frame_000010", "val/images/frame_000011", "default/frame_000012"])
    )
    assert sorted(picture_by_frame(back)) == [10, 11, 12]
    assert import_report(back) == ""


@every_format
def test_names_in_two_patterns_can_be_of_two_videos(tmp_path: Path, format: str) -> None:
    assert_refused(
        write_dataset(tmp_path, format, ["frame_000010", "img_000011"]), None, "'frame_' (1), 'img_' (1)", "video=NAME"
    )


@every_format
def test_folders_decide_only_where_names_do_not(tmp_path: Path, format: str) -> None:
    back = read_onto_drive(write_dataset(tmp_path / "a", format, ["batch1/drive_000000", "batch2/drive_000010"]))
    assert sorted(picture_by_frame(back)) == [0, 10]
    assert_refused(
        write_dataset(tmp_path / "b", format, ["cam1/drive_frame_000010", "cam2/drive_frame_000010"]),
        None,
        "is frame 10, as",
    )
    assert_refused(
        write_dataset(tmp_path / "c", format, ["a/drive/frame_000010", "b/drive/frame_000011"]), None, "'a/drive' (1)"
    )


@pytest.mark.parametrize("format", [name for name in IMAGE_FORMATS if name != "gtsdb"])
def test_our_exports_are_read_without_a_report(tmp_path: Path, format: str) -> None:
    data = make_dataset(make_track("m1", range(95, 100)))
    export_dataset(data, FORMATS[format], tmp_path / "out", zipped=False)
    back = read_dataset(tmp_path / "out", target_of(data))
    assert (back.repaired, back.skipped) == ((), ())


def test_our_manifest_identifies_exports_in_benchmark_formats(tmp_path: Path) -> None:
    data = make_dataset(make_track("m1", range(95, 100)))
    export_dataset(data, FORMATS["gtsdb"], tmp_path / "out", zipped=False)
    assert import_report(read_dataset(tmp_path / "out", target_of(data))) == ""
