"""Traps of MOT, GTSDB and GTSRB crops: each is repaired, or refused with file, line and rule."""

from __future__ import annotations

import configparser
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.exchange.image_datasets import assert_refused, read_onto_drive, write_text
from tests.exchange.small_datasets import CLASS_NAMES, GTSRB, make_dataset, make_track, make_video, tracks_of
from tsr_engine.evaluation.track_tables import read_mot_truth
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.formats import ExportOptions
from tsr_engine.exchange.gtsrb.writer import crop_with_border
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.exchange.split import make_split
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.io.gtsrb import read_items
from tsr_engine.io.video_writer import VideoWriter


def _only_track(dataset: Dataset) -> tuple[list[int], list[list[float]]]:
    (track,) = tracks_of(dataset).values()
    return track.frames.tolist(), track.boxes.tolist()


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rows") / "drive.mp4"
    rng = np.random.default_rng(5)
    with VideoWriter(path, 64, 48, Fraction(25)) as writer:
        for _ in range(12):
            writer.write(cv2.resize(rng.integers(0, 255, (6, 8, 3), dtype=np.uint8), (64, 48)))
    return path


def _dataset_on(clip: Path, *tracks: object) -> Dataset:
    video = replace(make_video(tracks, frames=12), width=64, height=48, path=clip)  # type: ignore[arg-type]
    return Dataset(GTSRB, (video,))


# ----------------------------------------------------------------------------------------------------------------- MOT


def test_mot_has_an_exact_sequence_file(tmp_path: Path) -> None:
    dataset = make_dataset(make_track("m7", [10, 11], boxes=[(10, 20, 30, 50)] * 2), rate=Fraction(30000, 1001))
    export_dataset(dataset, FORMATS["mot"], tmp_path / "out", zipped=False)
    parser = configparser.ConfigParser()
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read(tmp_path / "out" / "seqinfo.ini")
    info = dict(parser["Sequence"])
    assert list(info) == ["name", "imDir", "frameRate", "seqLength", "imWidth", "imHeight", "imExt"]
    assert [info[name] for name in ("frameRate", "seqLength", "imWidth", "imHeight")] == ["30", "100", "640", "360"]
    rows = (tmp_path / "out" / "gt" / "gt.txt").read_text().splitlines()
    assert rows == ["11,7,10.00,20.00,20.00,30.00,1,15,1", "12,7,10.00,20.00,20.00,30.00,1,15,1"]
    assert (tmp_path / "out/gt/labels.txt").read_text().splitlines()[14] == CLASS_NAMES[14]
    assert read_mot_truth(tmp_path / "out/gt/gt.txt").frame.tolist() == [10, 11]


def test_mot_counts_from_one(tmp_path: Path) -> None:
    dataset = make_dataset(make_track("m7", [10], boxes=[(10, 20, 30, 50)]))
    reported = export_dataset(
        dataset, FORMATS["mot"], tmp_path / "out", ExportOptions(switches={"origin": "1"}), zipped=False
    )
    assert reported.content["format"]["origin"] == 1
    assert (tmp_path / "out/gt/gt.txt").read_text() == "11,7,11.00,21.00,20.00,30.00,1,15,1\n"
    # Our manifest says where frames begin; without it, the user says so.
    assert _only_track(read_onto_drive(tmp_path / "out", "mot"))[1] == [[10, 20, 30, 50]]
    (tmp_path / "out" / "manifest.json").unlink()
    assert _only_track(read_onto_drive(tmp_path / "out", "mot"))[1] == [[11, 21, 31, 51]]
    assert _only_track(read_onto_drive(tmp_path / "out", "mot", origin="1"))[1] == [[10, 20, 30, 50]]


def test_mot_scores_are_exported_as_detections(tmp_path: Path) -> None:
    dataset = make_dataset(make_track("m1", [0, 1], boxes=[(10, 20, 30, 50)] * 2, score=np.array([0.5, np.nan])))
    export_dataset(dataset, FORMATS["mot"], tmp_path / "out", zipped=False)
    path = tmp_path / "out" / "det" / "det.txt"
    assert path.read_text() == "1,-1,10.00,20.00,20.00,30.00,0.5,-1,-1,-1\n"
    (track,) = tracks_of(read_onto_drive(path, "mot")).values()
    assert (track.frames.tolist(), track.score.tolist(), track.label) == ([0], [0.5], -1)
    assert track.silent is not None, "rows without a class say nothing about it"


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("0,1,10,10,20,20,1,15,1", ("line 1", "frame 0 must be in 1 to 100", "first_frame=0")),
        ("101,1,10,10,20,20,1,15,1", ("line 1", "1 to 100")),
        ("1,1,nan,10,20,20,1,15,1", ("line 1", "finite")),
        ("1,1,10,10,-20,20,1,15,1", ("line 1", "positive width")),
        ("1,1.5,10,10,20,20,1,15,1", ("line 1", "track id")),
        ("1,1,10,10,20,20,0.5,15,1", ("line 1", "column 7", "results have 10")),
        ("1,1,10,10,20,20,1,15,7", ("line 1", "visibility")),
        ("1,1,10,10,20", ("line 1", "9 columns", "Got 5")),
        ("1,1,10,10,20,20,1,15,1\n1,2,10,10,20,20", ("line 2", "9 columns")),
        ("1,1,ten,10,20,20,1,15,1", ("line 1", "column 3")),
        ("1,1,10,10,20,20,1,15,1\n1,1,90,10,20,20,1,15,1", ("line 2", "second, different box")),
    ],
)
def test_mot_that_breaks_a_rule(tmp_path: Path, row: str, words: tuple[str, ...]) -> None:
    assert_refused(write_text(tmp_path, "gt.txt", row + "\n"), "mot", "gt.txt", *words)


def test_mot_classes_that_count_from_zero(tmp_path: Path) -> None:
    write_text(tmp_path, "gt/gt.txt", "1,1,10,10,20,20,1,0,1\n")
    write_text(tmp_path, "gt/labels.txt", "stop\nyield\n")
    assert_refused(tmp_path, "mot", "gt/gt.txt, line 1", "class 0", "first_class=0")
    (track,) = tracks_of(read_onto_drive(tmp_path, "mot", first_class="0")).values()
    assert track.label == 14


def test_mot_of_frames_that_count_from_zero(tmp_path: Path) -> None:
    path = write_text(tmp_path, "gt.txt", "0,1,10,10,20,20,1,14,1\n")
    assert _only_track(read_onto_drive(path, "mot", first_frame="0"))[0] == [0]


# --------------------------------------------------------------------------------------------------------------- GTSDB


def test_gtsdb_export_is_read_by_the_engine(tmp_path: Path, clip: Path) -> None:
    dataset = _dataset_on(
        clip, make_track("m1", [3], boxes=[(10, 11, 30, 33)]), make_track("h2", [5], label=-1, boxes=[(1, 1, 9, 9)])
    )
    reported = export_dataset(dataset, FORMATS["gtsdb"], tmp_path / "out", ExportOptions(pictures="all"), zipped=False)
    assert (tmp_path / "out/gt.txt").read_text() == "00003.jpg;10;11;29;32;14\n"
    scenes = read_gtsdb(tmp_path / "out")
    assert len(scenes) == 12
    assert (tmp_path / "out/pictures.txt").read_text().splitlines() == [scene.name for scene in scenes]
    assert scenes[3].boxes.tolist() == [[10, 11, 30, 33]]
    assert reported.content["format"]["corners"] == "inclusive"
    assert any("not one of the 43 classes" in item["reason"] for item in reported.skipped)


def test_gtsdb_corners(tmp_path: Path) -> None:
    path = write_text(tmp_path, "gt.txt", "00010.ppm;10;11;29;32;14\n")
    assert _only_track(read_onto_drive(path, "gtsdb"))[1] == [[10, 11, 30, 33]]
    assert _only_track(read_onto_drive(path, "gtsdb", corners="exclusive"))[1] == [[10, 11, 29, 32]]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("00010.ppm;10;11;29;32", ("line 1", "file;left;top")),
        ("00010.ppm;10;11;29;32;43", ("line 1", "class 43", "0 to 42")),
        ("00010.ppm;10.5;11;29;32;4", ("line 1", "whole numbers")),
        ("00010.ppm;-1;11;29;32;4", ("line 1", "pixels from 0")),
        ("00010.ppm;40;11;29;32;4", ("line 1", "positive width")),
        ("00100.ppm;10;11;29;32;4", ("line 1", "0 to 99")),
        ("picture.ppm;10;11;29;32;4", ("line 1", "no frame number")),
    ],
)
def test_gtsdb_that_breaks_a_rule(tmp_path: Path, row: str, words: tuple[str, ...]) -> None:
    assert_refused(write_text(tmp_path, "gt.txt", row + "\n"), "gtsdb", "gt.txt", *words)


# --------------------------------------------------------------------------------------------------------------- GTSRB


def test_crops_at_the_edge_repeat_the_last_pixel() -> None:
    picture = np.arange(48 * 64 * 3, dtype=np.uint32).reshape(48, 64, 3).astype(np.uint8)
    crop, roi = crop_with_border(picture, (0, 2, 60, 22))
    assert roi == (6, 5, 66, 25)
    assert crop.shape == (30, 72, 3)
    assert (crop[5:25, 6:66] == picture[2:22, 0:60]).all()
    assert (crop[5:25, 0] == picture[2:22, 0]).all()
    assert (crop[0, 6:66] == picture[0, 0:60]).all()
    assert (crop[5:25, -1] == picture[2:22, 63]).all()


def test_crops_are_read_by_the_engine_like_the_benchmark(tmp_path: Path, clip: Path) -> None:
    tracks = (
        make_track("m1", [2, 3, 7], boxes=[(0, 0, 20, 20), (1, 1, 22, 23), (30, 20, 64, 48)]),
        make_track("m2", [3], boxes=[(40, 10, 60, 31)]),
        make_track("m3", [4], label=1, boxes=[(5, 5, 25, 26)]),
        make_track("m4", [4], label=-1, boxes=[(5, 5, 25, 26)]),
    )
    reported = export_dataset(
        _dataset_on(clip, *tracks),
        FORMATS["gtsrb"],
        tmp_path / "out",
        ExportOptions(pictures="annotated"),
        zipped=False,
    )
    items = {item.filename: item for item in read_items(tmp_path / "out") if item.class_id == 14}
    assert sorted(items) == ["00000_00000.ppm", "00000_00001.ppm", "00000_00002.ppm", "00001_00000.ppm"]
    assert items["00000_00001.ppm"].roi == (5, 5, 26, 27)
    for item in items.values():
        picture = cv2.imread(str(item.path))
        assert item.roi is not None
        assert item.roi[2] + item.roi[0] == picture.shape[1]
    assert (tmp_path / "out/00001/GT-00001.csv").read_text().splitlines()[1] == "00000_00000.ppm;30;31;5;5;25;26;1"
    assert any("not one of the 43 classes" in item["reason"] for item in reported.skipped)
    assert reported.counts["pictures"] == len(list((tmp_path / "out").rglob("*.ppm"))) == 5


def test_crops_of_one_sign_are_in_one_subset(tmp_path: Path, clip: Path) -> None:
    tracks = [make_track(f"m{k}", [k, k + 1, k + 2], boxes=[(5, 5, 25, 26)] * 3) for k in range(8)]
    dataset = _dataset_on(clip, *tracks)
    split = make_split(dataset, {"train": 0.5, "val": 0.5}, seed=1, rule="track")
    options = ExportOptions(pictures="annotated", split=split, switches={"picture": "png"})
    export_dataset(dataset, FORMATS["gtsrb"], tmp_path / "out", options, zipped=False)
    sides = {side: {p.name[:5] for p in (tmp_path / "out" / side / "00014").glob("*.png")} for side in ("train", "val")}
    assert not sides["train"] & sides["val"]
    assert len(sides["train"] | sides["val"]) == 8
    assert all(sides.values())


def test_crops_of_the_benchmark_have_no_position(tmp_path: Path) -> None:
    header = "Filename;Width;Height;Roi.X1;Roi.Y1;Roi.X2;Roi.Y2;ClassId"
    write_text(tmp_path, "00014/GT-00014.csv", f"{header}\n00000_00000.ppm;29;30;5;6;24;25;14\n")
    assert_refused(tmp_path, "gtsrb", "crops.csv", "where in the video")


def _of_videos(folder: Path, *names: str) -> Path:
    """Crops of videos with these names, without a manifest; each box lies 10 px right of the one before."""
    write_text(
        folder,
        "00014/GT-00014.csv",
        "Filename;Width;Height;RoiX1;RoiY1;RoiX2;RoiY2;ClassId\n"
        + "".join(f"{k:05d}_00000.ppm;29;30;5;6;24;25;14;\n" for k in range(len(names))),
    )
    rows = "".join(
        f"00014/{k:05d}_00000.ppm,{name},{'b' * 63}{k},3,{10 * k},0,,m{k},1,0,0,,open,engine,\n"
        for k, name in enumerate(names)
    )
    head = "file,video,video_sha256,frame,left,top,picture_sha256,uid,key,occluded,ignore,score,state,source,note\n"
    write_text(folder, "crops.csv", head + rows)
    return folder


def test_crops_are_matched_to_their_video(tmp_path: Path) -> None:
    found = read_onto_drive(_of_videos(tmp_path / "one", "other.mp4"), "gtsrb")
    assert "names other.mp4" in found.repaired[0]
    assert _only_track(found) == ([3], [[5, 6, 24, 25]])
    crops = tmp_path / "one/crops.csv"
    crops.write_text(crops.read_text().replace("m0,1,0,0,", "m0,1,0,1,"))
    (track,) = tracks_of(read_onto_drive(crops.parent, "gtsrb")).values()
    np.testing.assert_array_equal(track.ignore, [True])
    two = _of_videos(tmp_path / "two", "other.mp4", "rear-drive.mp4")
    assert_refused(two, "gtsrb", "2 videos, none about drive.mp4", "other.mp4", "task=NAME")
    assert _only_track(read_onto_drive(two, "gtsrb", task="rear-drive"))[1] == [[15, 6, 34, 25]]
