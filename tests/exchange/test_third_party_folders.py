"""Folders and archives of other tools: files, lists and names of pictures as these tools write them."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest

from tests.exchange.image_datasets import (
    IMAGE_FORMATS,
    assert_refused,
    coco_file,
    import_report,
    picture_by_frame,
    read_onto_drive,
    write_dataset,
    write_text,
)

HASH = "0a1b2c3d4e5f60718293a4b5c6d7e8f3"


def test_archives_of_roboflow(tmp_path: Path) -> None:
    notes = {"README.dataset.txt": "# signs\n", "README.roboflow.txt": "Exported via roboflow.com\n"}
    for kind in ("coco", "yolo", "voc"):
        files = dict(notes)
        for subset, frame in (("train", 10), ("valid", 11), ("test", 12)):
            name = f"drive_mp4-{frame:04d}_jpg.rf.{HASH}"
            made = write_dataset(tmp_path / kind / subset, kind, [name])
            (path,) = (each for each in made.rglob("*") if each.is_file() and each.name != "data.yaml")
            at = {"coco": "_annotations.coco.json", "yolo": f"labels/{name}.txt", "voc": f"{name}.xml"}[kind]
            files[f"{subset}/{at}"] = path.read_text()
        if kind == "yolo":
            files["data.yaml"] = "names: ['stop']\nnc: 1\n"
        with zipfile.ZipFile(tmp_path / f"{kind}.zip", "w") as archive:
            for name, text in files.items():
                archive.writestr(name, text)
        assert sorted(picture_by_frame(read_onto_drive(tmp_path / f"{kind}.zip"))) == [10, 11, 12], kind


def test_coco_files_named_after_videos(tmp_path: Path) -> None:
    for index, name in enumerate(("instances_other", "instances_drive")):
        made = write_dataset(tmp_path / str(index), "coco", ["frame_000010", "frame_000011"])
        (tmp_path / "in").mkdir(exist_ok=True)
        (made / "instances.json").rename(tmp_path / "in" / f"{name}.json")
    back = read_onto_drive(tmp_path / "in")
    assert picture_by_frame(back) == {10: 0, 11: 1}
    assert "'other' (2)" in import_report(back)
    for name in ("instances_other", "instances_drive"):
        (tmp_path / "in" / f"{name}.json").rename(tmp_path / "in" / f"{name.replace('instances_', '')}s.json")
    assert_refused(tmp_path / "in", None, "has pictures of 'drives' (2), 'others' (2)")


def test_a_picture_listed_by_several_coco_files(tmp_path: Path) -> None:
    for name in ("instances_train", "person_keypoints_train"):
        made = write_dataset(tmp_path / name, "coco", ["frame_000010"])
        (tmp_path / "in").mkdir(exist_ok=True)
        (made / "instances.json").rename(tmp_path / "in" / f"{name}.json")
    assert "1 picture is listed by several files" in import_report(read_onto_drive(tmp_path / "in"))


def test_a_track_id_in_several_coco_files_is_reported(tmp_path: Path) -> None:
    """Each task of CVAT numbers its tracks from 0, and each subset of a project has a file (``_export_track``)."""
    attributes = {"track_id": 0, "keyframe": True}
    for subset, frame in (("train", 10), ("val", 50)):
        content = coco_file([{"file_name": f"frame_{frame:06d}.png"}], [{"attributes": attributes}])
        write_text(tmp_path, f"annotations/instances_{subset}.json", json.dumps(content))
    back = read_onto_drive(tmp_path)
    assert [track.frames.tolist() for track in back.videos[0].tracks()] == [[10, 50]]
    assert "Boxes became part of a track of an earlier file, which has the same track id: 1" in import_report(back)


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
    path = write_dataset(tmp_path, "coco", ["x"]) / "instances.json"
    content = json.loads(path.read_text())
    content["images"][0]["file_name"] = address
    path.write_text(json.dumps(content))
    back = read_onto_drive(path)
    assert (picture_by_frame(back), import_report(back)) == ({10: 0}, "")


def test_voc_with_another_frame_inside_is_reported(tmp_path: Path) -> None:
    path = write_dataset(tmp_path, "voc", ["frame_000010", "scene"])
    for name, inside in (("frame_000010", "frame_000012.jpg"), ("scene", "frame_000013.jpg")):
        file = path / "Annotations" / f"{name}.xml"
        file.write_text(file.read_text().replace("<annotation>", f"<annotation><filename>{inside}</filename>"))
    back = read_onto_drive(path)
    assert sorted(picture_by_frame(back)) == [10, 13]
    assert (
        "imported by their own name: 1; the first is frame_000010.xml, 'frame_000010.xml' frame_000012.jpg"
        in import_report(back)
    )


def test_tracks_of_imagenet_vid(tmp_path: Path) -> None:
    """Objects of ImageNet VID (ILSVRC 2015) have ``<trackid>``, and corners in another order."""
    corners = "<bndbox><xmax>{}</xmax><xmin>10</xmin><ymax>40</ymax><ymin>20.5</ymin></bndbox>"
    for frame, tracks in ((10, (0, 1)), (50, (1,))):
        objects = "".join(
            f"<object><trackid>{track}</trackid><name>stop</name>{corners.format(30 + track)}"
            "<occluded>0</occluded><generated>0</generated></object>"
            for track in tracks
        )
        xml = f"<annotation><folder>drive</folder><filename>{frame:06d}</filename>{objects}</annotation>"
        write_text(tmp_path, f"{frame:06d}.xml", xml)
    back = read_onto_drive(tmp_path, "voc", first_frame="0")
    assert {track.uid: track.frames.tolist() for track in back.videos[0].tracks()} == {
        "track0": [10],
        "track1": [10, 50],
    }
    assert "no track id" not in import_report(back)


@pytest.mark.parametrize(
    "element", ["<folder>{}</folder>", "<folder/><path>/data/{}/x.jpg</path>", "<path>D:\\{}\\x.jpg</path>"]
)
def test_voc_whose_folder_names_a_video(tmp_path: Path, element: str) -> None:
    path = write_dataset(tmp_path, "voc", ["frame_000010", "frame_000011"])
    for name, inside in (("frame_000010", "other"), ("frame_000011", "drive")):
        file = path / "Annotations" / f"{name}.xml"
        file.write_text(file.read_text().replace("<annotation>", f"<annotation>{element.format(inside)}"))
    back = read_onto_drive(path)
    assert sorted(picture_by_frame(back)) == [11]
    assert "'other' (1)" in import_report(back)


def test_pictures_of_another_video_may_have_another_size(tmp_path: Path) -> None:
    path = write_dataset(tmp_path, "voc", ["other/frame_000010", "drive/frame_000010"])
    file = path / "Annotations" / "other" / "frame_000010.xml"
    size = "<annotation><size><width>1280</width><height>720</height></size>"
    file.write_text(file.read_text().replace("<annotation>", size))
    assert sorted(picture_by_frame(read_onto_drive(path))) == [10]


@pytest.mark.parametrize(
    ("format", "list_file"),
    [("yolo", "train.txt"), ("yolo", "images.txt"), ("voc", "ImageSets/Main/default.txt"), ("gtsdb", "pictures.txt")],
)
def test_a_list_of_all_pictures_fixes_the_first_number(tmp_path: Path, format: str, list_file: str) -> None:
    path = write_dataset(tmp_path, format, ["drive_000010"])
    (path / list_file).parent.mkdir(parents=True, exist_ok=True)
    (path / list_file).write_text("".join(f"data/drive_{number:06d}.jpg\n" for number in range(1, 101)))
    back = read_onto_drive(path)
    assert picture_by_frame(back) == {9: 0}
    assert "they run from 1 to 100" in import_report(back)
    (path / list_file).write_text("data/drive_000000.jpg\ndata/other_000500.jpg -1\n")
    assert picture_by_frame(read_onto_drive(path)) == {10: 0}
    (path / list_file).write_text("data/drive_000300.jpg\n")
    assert_refused(path, None, "frame 300 must be in 0 to 99")


def test_yolo_folder_of_fiftyone(tmp_path: Path) -> None:
    """FiftyOne's YOLOv4 export: labels beside the pictures, and a list of these."""
    data = tmp_path / "data"
    data.mkdir()
    (tmp_path / "obj.names").write_text("stop\nyield\n")
    (tmp_path / "images.txt").write_text("\n".join(f"data/{number:06d}.jpg" for number in range(1, 101)))
    for number in (11, 12):
        (data / f"{number:06d}.txt").write_text(f"0 0.{number} 0.5 0.1 0.1")
    back = read_onto_drive(tmp_path)
    assert sorted(picture_by_frame(back)) == [10, 11]
    assert {track.label for track in back.videos[0].tracks()} == {14}


@pytest.mark.parametrize("format", IMAGE_FORMATS)
def test_files_of_macos_are_ignored(tmp_path: Path, format: str) -> None:
    path = write_dataset(tmp_path / "in", format, ["frame_000010", "frame_000011"])
    for file in [each for each in path.rglob("*") if each.is_file()]:
        twin = tmp_path / "__MACOSX" / file.relative_to(tmp_path).with_name(f"._{file.name}")
        for index in (twin, file.with_name(f"._{file.name}")):
            index.parent.mkdir(parents=True, exist_ok=True)
            index.write_bytes(b"\0\x05\x16\x07\xff")
    (tmp_path / ".DS_Store").write_bytes(b"\xff")
    back = read_onto_drive(tmp_path)
    assert sorted(picture_by_frame(back)) == [10, 11]
    assert import_report(back) == ""


def test_a_class_list_with_another_name(tmp_path: Path) -> None:
    path = write_dataset(tmp_path, "yolo", ["frame_000010"])
    (path / "data.yaml").rename(path / "signs.yaml")
    (track,) = read_onto_drive(path).videos[0].tracks()
    assert track.label == 14
    (path / "args.yaml").write_text("task: detect\n")
    assert any("has no class names" in sentence for sentence in read_onto_drive(path).repaired), (
        "two files: nobody guesses"
    )


def test_yolo_folders_of_cvat_have_the_name_of_any_subset(tmp_path: Path) -> None:
    write_text(tmp_path, "obj.names", "stop\n")
    for subset, frame in (("train", 10), ("valid", 50), ("Night", 60)):
        write_text(tmp_path, f"{subset}.txt", f"data/obj_{subset}_data/frame_{frame:06d}.jpg\n")
        write_text(tmp_path, f"obj_{subset}_data/frame_{frame:06d}.txt", "0 .5 .5 .1 .1\n")
    frames = [track.frames.tolist() for track in read_onto_drive(tmp_path).videos[0].tracks()]
    assert sorted(frames) == [[10], [50], [60]]


def test_class_names_beside_label_files(tmp_path: Path) -> None:
    """labelImg writes ``classes.txt`` into the folder of the label files."""
    for folder, frame in (("train", 10), ("val", 50)):
        write_text(tmp_path, f"{folder}/classes.txt", "yield\nstop\n")
        write_text(tmp_path, f"{folder}/frame_{frame:06d}.txt", "1 .5 .5 .1 .1\n")
    assert [track.label for track in read_onto_drive(tmp_path, "yolo").videos[0].tracks()] == [14, 14]
    write_text(tmp_path, "val/classes.txt", "stop\nyield\n")
    assert_refused(tmp_path, "yolo", "val/classes.txt: has other classes than train/classes.txt")


def test_class_names_are_looked_for_in_the_import_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_text(tmp_path, "frame_000010.txt", "1 .5 .5 .1 .1\n")
    write_text(tmp_path, "train/frame_000050.txt", "1 .5 .5 .1 .1\n")
    looked_for, is_file = set(), Path.is_file

    def note(path: Path) -> bool:
        looked_for.add(path)
        return is_file(path)

    monkeypatch.setattr(Path, "is_file", note)
    assert len(list(read_onto_drive(tmp_path, "yolo").videos[0].tracks())) == 2
    folders = {path.parent for path in looked_for if path.name == "classes.txt"}
    assert folders == {tmp_path, tmp_path / "labels", tmp_path / "train"}


def test_a_frame_that_contradicts_the_picture_name_is_reported(tmp_path: Path) -> None:
    path = write_dataset(tmp_path, "coco", ["frame_000010", "front"]) / "instances.json"
    content = json.loads(path.read_text())
    for image, frame in zip(content["images"], (11, 12), strict=True):
        image["frame"] = frame
    path.write_text(json.dumps(content))
    back = read_onto_drive(path)
    assert picture_by_frame(back) == {11: 0, 12: 1}
    assert "got the frame that the file states, not that of their names: 1" in import_report(back)
