"""Small files of other tools, as public reports describe them; their boxes are ``box(frame)``."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping

TEN = range(10, 16)
YAML = "names:\n  0: stop\n"


def box(frame: int) -> tuple[float, float, float, float]:
    """Edges of the sign, px."""
    return 100 + frame, 80 + frame / 2, 140 + frame, 120 + frame / 2


def yolo(frame: int, *more: object) -> str:
    """One row of a label file."""
    x1, y1, x2, y2 = box(frame)
    cells = (0, (x1 + x2) / 1280, (y1 + y2) / 720, (x2 - x1) / 640, (y2 - y1) / 360, *more)
    return " ".join(f"{cell:.9f}" if isinstance(cell, float) else str(cell) for cell in cells) + "\n"


def roboflow(hashes: Iterable[str]) -> dict[str, str]:
    """Label files of the frames 10, 11, 12."""
    names = (f"train/labels/drive_mp4-{frame:04d}_jpg.rf.{digits}.txt" for frame, digits in enumerate(hashes, 10))
    return {"data.yaml": YAML, **{name: yolo(frame) for frame, name in enumerate(names, 10)}}


def save_txt(frames: Iterable[int]) -> dict[str, str]:
    """Label files of Ultralytics, which counts from 1."""
    return {"data.yaml": YAML, **{f"labels/drive_{frame + 1}.txt": yolo(frame, 1) for frame in frames}}


def coco(names: Mapping[str, int], *, image: object = None, note: object = None, **more: object) -> str:
    """A COCO file with one box per picture: name and the frame of its box."""
    images, notes = [], []
    for number, (name, frame) in enumerate(names.items(), 1):
        x1, y1, x2, y2 = box(frame)
        images.append({"id": number, "file_name": name, "width": 640, "height": 360, **dict(image or {})})  # type: ignore[call-overload]
        said = {"id": number, "image_id": number, "category_id": 1, "bbox": [x1, y1, x2 - x1, y2 - y1]}
        notes.append({**said, **dict(note or {})})  # type: ignore[call-overload]
    return json.dumps({"images": images, "annotations": notes, "categories": [{"id": 1, "name": "stop"}], **more})


def cocovid() -> str:
    """Two tracks in four frames; names count from 1, ``frame_id`` from 0."""
    image = {"video_id": 1, "width": 640, "height": 360}
    note = {"video_id": 1, "category_id": 1}
    images = [{**image, "id": k + 1, "file_name": f"drive/img1/{k + 1:06d}.jpg", "frame_id": k} for k in range(100)]
    notes = [
        {**note, "id": 10 * k + n, "image_id": k + 1, "instance_id": n, "bbox": [100, y, 40, 40]}
        for k in (10, 15, 20, 25)
        for n, y in ((5, 80), (6, 200))
    ]
    tables = {"videos": [{"id": 1, "name": "drive"}], "categories": [{"id": 1, "name": "stop"}]}
    return json.dumps({**tables, "images": images, "annotations": notes})


def boxes_xml(frames: Iterable[int], first: int = 0, flags: str = 'keyframe="1" ') -> str:
    """Boxes of a CVAT track and its end; ``first`` is the number of the video's first frame."""
    rows = [(frame, 0) for frame in frames]
    rows.append((rows[-1][0] + 1, 1))
    text = ""
    for frame, outside in rows:
        x1, y1, x2, y2 = box(frame - outside)
        text += f'<box frame="{frame + first}" {flags}outside="{outside}" xtl="{x1}" ytl="{y1}" xbr="{x2}" ybr="{y2}"/>'
    return text


def task_xml(number: int, source: str, frames: int) -> str:
    """A task of a CVAT project."""
    return (
        f"<task><id>{number}</id><name>{source[:-4]}</name><size>{frames}</size><start_frame>0</start_frame>"
        f"<stop_frame>{frames - 1}</stop_frame><original_size><width>640</width><height>360</height></original_size>"
        f"<source>{source}</source></task>"
    )


def region(frames: Iterable[int] = TEN) -> dict[str, object]:
    """A video rectangle of Label Studio with a key frame in every frame."""
    size = {"width": 40 / 6.4, "height": 40 / 3.6, "rotation": 0}
    keys = [
        {"frame": f + 1, "time": (f + 1) / 30, "x": x / 6.4, "y": y / 3.6, **size, "enabled": f != max(frames)}
        for f, (x, y, *_) in ((frame, box(frame)) for frame in frames)
    ]
    value = {"framesCount": 100, "duration": 100 / 30, "labels": ["stop"], "sequence": keys}
    return {"id": "r1", "type": "videorectangle", "from_name": "box", "to_name": "video", "value": value}


def tasks(*videos: str) -> dict[str, str]:
    """A Label Studio export: the last task has the boxes ``box``, the others' boxes have other times."""
    regions = [region((50, 51))] * (len(videos) - 1) + [region()]
    made = [
        {"id": n, "data": {"video": video}, "annotations": [{"result": [found]}]}
        for n, (video, found) in enumerate(zip(videos, regions, strict=True), 1)
    ]
    return {"export.json": json.dumps(made)}


def rows(layout: str, frames: Iterable[int] = TEN, header: str = "") -> str:
    """Rows of a table: ``{f}`` counts from 0, ``{n}`` from 1, then edges and sizes."""
    text = f"{header}\n" if header else ""
    for frame in frames:
        x1, y1, x2, y2 = box(frame)
        text += layout.format(f=frame, n=frame + 1, x1=x1, y1=y1, x2=x2, y2=y2, w=40, h=40) + "\n"
    return text


def results(**more: object) -> list[dict[str, object]]:
    """Rows of Ultralytics' ``to_json`` with a frame number added."""
    sides = ("x1", "y1", "x2", "y2")
    return [
        {"frame": f, "name": "stop", "class": 0, "box": dict(zip(sides, box(f), strict=True)), "track_id": 3, **more}
        for f in TEN
    ]
