"""Data sets in FiftyOne's layouts, rendered from its published templates and exporters.

FiftyOne brings a database server, so it is not installed. Facts from ``cvat_video_interpolation_template.xml`` and
``cvat_image_annotation_template.xml`` of voxel51/fiftyone: frames count from 1 in FiftyOne and from 0 in its CVAT
files; edges are whole pixels; a flag that a label lacks is not written; a track ends with a box marked as outside, in
the frame after its last one. ``to_frames`` names pictures ``000001.jpg``, from 1.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from tests.oracles.conftest import CLASSES, FRAMES, HEIGHT, WIDTH, Box

__all__ = ["Row", "coco", "cvat_images", "cvat_video", "yolov4", "yolov5"]

Row = tuple[Box, int]
"""A box and the number of its track."""


def _rounded(box: Box) -> list[int]:
    return [round(edge) for edge in box[2:]]


def _head(name: str, mode: str, size: bool) -> str:
    labels = "".join(
        f"<label>\n<name>{escape(label)}</name>\n<attributes>\n</attributes>\n</label>\n" for label in CLASSES
    )
    original = f"<original_size>\n<width>{WIDTH}</width>\n<height>{HEIGHT}</height>\n</original_size>\n" if size else ""
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n<annotations>\n<version>1.1</version>\n<meta>\n<task>\n<id>0</id>\n'
        f"<name>{escape(name)}</name>\n<size>{FRAMES}</size>\n<mode>{mode}</mode>\n<overlap></overlap>\n"
        "<bugtracker></bugtracker>\n<flipped>False</flipped>\n<created>None</created>\n<updated>None</updated>\n"
        f"<labels>\n{labels}</labels>\n<segments>\n<segment>\n<id>0</id>\n<start>0</start>\n<stop>{FRAMES - 1}</stop>\n"
        "<url></url>\n</segment>\n</segments>\n<owner>\n<username></username>\n<email></email>\n</owner>\n"
        f"{original}</task>\n<dumped>2026-01-01 00:00:00.000000</dumped>\n</meta>\n"
    )


def cvat_video(rows: Sequence[Row], path: Path, keys: bool) -> None:
    """One file of ``CVATVideoDataset``; ``keys`` marks the first box of a track and its ends as key frames."""
    text = _head("drive", "interpolation", size=True)
    for number in sorted({track for _, track in rows}):
        own = {box[0]: box for box, track in rows if track == number}
        shown = {frame: (_rounded(box), 0, int(keys and frame == min(own))) for frame, box in own.items()}
        for frame in own:
            if frame + 1 not in own:
                shown[frame + 1] = (_rounded(own[frame]), 1, int(keys))
        text += f'<track id="{number}" label={quoteattr(own[min(own)][1])}>\n'
        for frame, ((x1, y1, x2, y2), outside, key) in sorted(shown.items()):
            said = f' outside="{outside}" ' + (f' keyframe="{key}" ' if key else "")
            text += f'<box frame="{frame}" xtl="{x1}" ytl="{y1}" xbr="{x2}" ybr="{y2}"{said}>\n</box>\n'
        text += "</track>\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + "</annotations>", encoding="utf-8")


def _by_frame(rows: Sequence[Row]) -> dict[int, list[Box]]:
    """Boxes of every frame of the video, as ``to_frames`` samples all of them."""
    return {frame: [box for box, _ in rows if box[0] == frame] for frame in range(FRAMES)}


def _picture(frame: int) -> str:
    return f"{frame + 1:06d}"


def cvat_images(rows: Sequence[Row], folder: Path) -> None:
    """``CVATImageDataset`` of the frames of a video."""
    text = _head("frames", "annotation", size=False)
    for frame, boxes in _by_frame(rows).items():
        text += f'<image id="{frame}" name="{_picture(frame)}.jpg" width="{WIDTH}" height="{HEIGHT}">\n'
        for box in boxes:
            x1, y1, x2, y2 = _rounded(box)
            text += f'<box label={quoteattr(box[1])} xtl="{x1}" ytl="{y1}" xbr="{x2}" ybr="{y2}">\n</box>\n'
        text += "</image>\n"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "labels.xml").write_text(text + "</annotations>", encoding="utf-8")


def coco(rows: Sequence[Row], folder: Path) -> None:
    """``COCODetectionDataset``: ``labels.json`` beside ``data``; ids count from 1, categories from 0."""
    frames = _by_frame(rows)
    content = {
        "info": {"year": "", "version": "", "description": "Exported from FiftyOne", "contributor": "", "url": ""},
        "licenses": [],
        "categories": [{"id": k, "name": name, "supercategory": None} for k, name in enumerate(CLASSES)],
        "images": [
            {
                "id": frame + 1,
                "file_name": f"{_picture(frame)}.jpg",
                "height": HEIGHT,
                "width": WIDTH,
                "license": None,
                "coco_url": None,
            }
            for frame in frames
        ],
        "annotations": [
            {
                "id": number,
                "image_id": frame + 1,
                "category_id": CLASSES.index(name),
                "bbox": [x1, y1, x2 - x1, y2 - y1],
                "area": (x2 - x1) * (y2 - y1),
                "iscrowd": 0,
            }
            for number, (frame, name, x1, y1, x2, y2) in enumerate(
                (box for boxes in frames.values() for box in boxes), 1
            )
        ],
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "labels.json").write_text(json.dumps(content), encoding="utf-8")


def _rows_of(boxes: Sequence[Box]) -> str:
    return "\n".join(
        f"{CLASSES.index(name)} {(x1 + x2) / 2 / WIDTH:f} {(y1 + y2) / 2 / HEIGHT:f} {(x2 - x1) / WIDTH:f} "
        f"{(y2 - y1) / HEIGHT:f}"
        for _, name, x1, y1, x2, y2 in boxes
    )


def yolov5(rows: Sequence[Row], folder: Path) -> None:
    """``YOLOv5Dataset``: ``dataset.yaml``, ``images/val``, ``labels/val``; frames without a box have no label file."""
    labels = folder / "labels" / "val"
    labels.mkdir(parents=True)
    names = "".join(f"  {k}: {name}\n" for k, name in enumerate(CLASSES))
    (folder / "dataset.yaml").write_text(f"names:\n{names}path: {folder}\nval: ./images/val/\n", encoding="utf-8")
    for frame, boxes in _by_frame(rows).items():
        if boxes:
            (labels / f"{_picture(frame)}.txt").write_text(_rows_of(boxes), encoding="utf-8")


def yolov4(rows: Sequence[Row], folder: Path) -> None:
    """``YOLOv4Dataset``: ``obj.names``, ``images.txt`` and the labels beside the pictures in ``data``."""
    data = folder / "data"
    data.mkdir(parents=True)
    frames = _by_frame(rows)
    (folder / "obj.names").write_text("\n".join(CLASSES), encoding="utf-8")
    (folder / "images.txt").write_text("\n".join(f"data/{_picture(frame)}.jpg" for frame in frames), encoding="utf-8")
    for frame, boxes in frames.items():
        (data / f"{_picture(frame)}.txt").write_text(_rows_of(boxes), encoding="utf-8")
