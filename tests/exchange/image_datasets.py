"""Small data sets of other tools that list pictures: one box of a stop sign in each, in every such format."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.exchange.small_datasets import make_dataset, target_of, tracks_of
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

IMAGE_FORMATS = ("coco", "yolo", "voc", "cvat-images", "datumaro", "gtsdb")


def _box(index: int) -> tuple[int, int, int, int]:
    """The box of the picture at this place in the list; its left edge encodes the place."""
    return 100 + index, 80, 140 + index, 120


def _files(format: str, names: Sequence[str]) -> dict[str, str]:
    """File contents by path; ``names`` are without suffix."""
    if format == "coco":
        return {"instances.json": json.dumps(coco_file([{"file_name": f"{name}.jpg"} for name in names]))}
    if format == "yolo":
        rows = {}
        for index, name in enumerate(names):
            x1, y1, x2, y2 = _box(index)
            row = f"0 {(x1 + x2) / 1280:.9f} {(y1 + y2) / 720:.9f} {40 / 640} {40 / 360:.9f}\n"
            rows[f"labels/train/{name}.txt"] = row
        return {"data.yaml": "names: [stop]\n", **rows}
    if format == "voc":
        return {
            f"Annotations/{name}.xml": "<annotation><object><name>stop</name><bndbox>"
            + "".join(f"<{tag}>{edge}.25</{tag}>" for tag, edge in zip(CORNERS, _box(index), strict=True))
            + "</bndbox></object></annotation>"
            for index, name in enumerate(names)
        }
    if format == "cvat-images":
        return {"annotations.xml": cvat_file([f'name="{name}"' for name in names])}
    if format == "gtsdb":
        lines = []
        for index, name in enumerate(names):
            x1, y1, x2, y2 = _box(index)
            lines.append(f"{name}.ppm;{x1};{y1};{x2 - 1};{y2 - 1};14\n")
        return {"gt.txt": "".join(lines)}
    items = []
    for index, name in enumerate(names):
        x1, y1, x2, y2 = _box(index)
        note = {"type": "bbox", "label_id": 0, "bbox": [x1, y1, x2 - x1, y2 - y1]}
        items.append({"id": name, "annotations": [note]})
    labels = {"label": {"labels": [{"name": "stop"}]}}
    return {"annotations/default.json": json.dumps({"info": {}, "categories": labels, "items": items})}


CORNERS = ("xmin", "ymin", "xmax", "ymax")


def coco_file(
    images: Sequence[dict[str, object]], notes: Sequence[dict[str, object]] = (), **more: object
) -> dict[str, object]:
    """A COCO file with a box in each image; ids count from 1 where nothing else is said."""
    listed = [{"id": number, **image} for number, image in enumerate(images, start=1)]
    boxes = []
    for index, image in enumerate(listed):
        x1, y1, x2, y2 = _box(index)
        note = notes[index] if notes else {}
        box = {"id": index, "image_id": image["id"], "category_id": 1, "bbox": [x1, y1, x2 - x1, y2 - y1]}
        boxes.append({**box, **note})
    return {"images": listed, "categories": [{"id": 1, "name": "stop"}], "annotations": boxes, **more}


def cvat_file(images: Sequence[str], meta: str = "") -> str:
    """A CVAT for images file with these attributes of each ``<image>``."""
    rows = []
    for index, image in enumerate(images):
        x1, y1, x2, y2 = _box(index)
        box = f'<box label="stop" occluded="0" xtl="{x1}" ytl="{y1}" xbr="{x2}" ybr="{y2}"/>'
        rows.append(f'<image id="{index}" {image}>{box}</image>\n')
    return f"<annotations>\n<meta>{meta}</meta>\n{''.join(rows)}</annotations>\n"


def write_dataset(folder: Path, format: str, names: Sequence[str]) -> Path:
    """Write a data set that lists these pictures, one box in each."""
    for name, text in _files(format, names).items():
        write_text(folder, name, text)
    return folder


def write_text(folder: Path, name: str, text: str) -> Path:
    """Write a file and the folders above it."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def yolo_folder(folder: Path, lines: str, *, names: str = "names: [stop, yield]\n", frame: int = 10) -> Path:
    """Write the label file of one picture, and ``data.yaml``."""
    write_text(folder, f"labels/train/frame_{frame:06d}.txt", lines)
    write_text(folder, "data.yaml", names)
    return folder


def read_onto_drive(path: Path, format: str | None = None, **switches: str) -> Dataset:
    """Read it onto ``drive.mp4``, 100 frames at 25 frames a second."""
    return read_dataset(path, target_of(make_dataset(), switches=switches), None if format is None else FORMATS[format])


def assert_refused(path: Path, format: str | None, *words: str, **switches: str) -> None:
    """Assert that reading is refused with these words."""
    with pytest.raises(ImportFormatError) as error:
        read_onto_drive(path, format, **switches)
    for word in words:
        assert word in str(error.value)


def import_report(dataset: Dataset) -> str:
    """The report without the classes, corners and tracks that these files have in common."""
    common = ("no track id", "corners")
    sentences = [sentence for sentence in dataset.repaired if not any(word in sentence for word in common)]
    return " ".join([*sentences, *(f"{item.what}: {item.reason}" for item in dataset.skipped)])


def picture_by_frame(dataset: Dataset) -> dict[int, int]:
    """Place of the picture in the list, by the frame that got its box."""
    return {
        frame: round(float(box[0])) - 100
        for track in tracks_of(dataset).values()
        for frame, box in zip(track.frames.tolist(), track.boxes, strict=True)
    }
