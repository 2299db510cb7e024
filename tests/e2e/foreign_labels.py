"""A CVAT file over a sample drive, with sign names of another country."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

__all__ = ["SLOVENIAN", "cvat_file"]

SLOVENIAN: Mapping[int, str] = {
    28: "otroci",
    1: "omejitev_30",
    2: "omejitev_50",
    11: "pedestrian_crossing",
    13: "yield",
}
"""Numbers of gtsrb-43 in the truth of the second sample, and what the file calls them."""


def cvat_file(truth: Path, names: Mapping[int, str], frames: int, size: tuple[int, int]) -> bytes:
    """The ground truth of a sample as CVAT for video 1.1 exports it.

    Args:
        truth: the table of the sample.
        names: the file's name of each class.
        frames: of the video.
        size: width and height, px.
    """
    tracks: dict[str, list[dict[str, str]]] = {}
    with truth.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if int(row["class_id"]) in names:
                tracks.setdefault(row["track_id"], []).append(row)
    root = ET.Element("annotations")
    ET.SubElement(root, "version").text = "1.1"
    task = ET.SubElement(ET.SubElement(root, "meta"), "task")
    for name, text in (("size", str(frames)), ("mode", "interpolation"), ("start_frame", "0")):
        ET.SubElement(task, name).text = text
    ET.SubElement(task, "stop_frame").text = str(frames - 1)
    labels = ET.SubElement(task, "labels")
    for name in names.values():
        label = ET.SubElement(labels, "label")
        ET.SubElement(label, "name").text = name
        ET.SubElement(label, "attributes")
    original = ET.SubElement(task, "original_size")
    ET.SubElement(original, "width").text, ET.SubElement(original, "height").text = map(str, size)
    for number, rows in enumerate(tracks.values()):
        track = ET.SubElement(root, "track", id=str(number), label=names[int(rows[0]["class_id"])], source="manual")
        for row in rows:
            _box(track, row, "0")
        if int(rows[-1]["frame"]) + 1 < frames:
            _box(track, {**rows[-1], "frame": str(int(rows[-1]["frame"]) + 1)}, "1")
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def _box(track: ET.Element, row: Mapping[str, str], outside: str) -> None:
    corners = {"xtl": row["x1"], "ytl": row["y1"], "xbr": row["x2"], "ybr": row["y2"]}
    ET.SubElement(track, "box", frame=row["frame"], keyframe="1", outside=outside, occluded="0", z_order="0", **corners)
