"""Files that libraries write about a video: sinks of rows, results of a tracker, tasks of an annotation tool.

Runs in the environments of the other libraries; called by ``run_library.py``. Standard input has the video's path and
its boxes in the same form.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

WIDTH, HEIGHT, FRAMES = 64, 48, 20
CLASSES = ["stop", "yield", "50 km/h"]
RATE = 25.0


def _given() -> tuple[str, dict[int, list[Any]]]:
    """The video, and the boxes of each frame."""
    given = json.load(sys.stdin)
    by_frame: dict[int, list[Any]] = {}
    for box in given["boxes"]:
        by_frame.setdefault(box[0], []).append(box)
    return given["video"], by_frame


# --------------------------------------------------------------------------------------------------------- supervision


def supervision_sink(format: str, path: Path) -> Any:
    """``KIND COLUMN [names]``: rows appended frame by frame, as in the documentation of the sinks."""
    import numpy as np
    import supervision as sv

    kind, column, *more = format.split()
    video, by_frame = _given()
    sink = sv.CSVSink(str(path)) if kind == "csv" else sv.JSONSink(str(path))
    with sink:
        for frame, _ in enumerate(sv.get_video_frames_generator(video)):
            rows = by_frame.get(frame, [])
            labels = [CLASSES.index(row[1]) for row in rows]
            found = sv.Detections(
                xyxy=np.array([row[2:6] for row in rows], dtype=np.float32).reshape(-1, 4),
                confidence=np.full(len(rows), 0.75, dtype=np.float32),
                class_id=np.array(labels, dtype=int),
                tracker_id=np.array([row[6]["track_id"] for row in rows], dtype=int),
                data={"class_name": np.array([CLASSES[label] for label in labels])} if more else {},
            )
            sink.append(found, {column: frame})
    return {}


# ---------------------------------------------------------------------------------------------------------- ultralytics


def _predicted(video: str, by_frame: dict[int, list[Any]], ids: bool, **params: Any) -> list[Any]:
    """Ultralytics' predictions on a video; a callback, as its trackers use, replaces the network's boxes by ours."""
    import torch
    from ultralytics import YOLO
    from ultralytics.utils.nms import TorchNMS

    # For videos it imports torchvision for speed; a CUDA build fails beside a PyTorch without CUDA.
    quicker = ModuleType("torchvision")
    quicker.ops = SimpleNamespace(nms=TorchNMS.nms)  # type: ignore[attr-defined]
    sys.modules["torchvision"] = quicker

    frame = iter(range(FRAMES))

    def found(predictor: Any) -> None:
        rows = [
            [*edges, *([said["track_id"]] if ids else []), 0.75, CLASSES.index(name)]
            for _, name, *edges, said in by_frame.get(next(frame), [])
        ]
        result = predictor.results[0]
        result.names = dict(enumerate(CLASSES))
        result.update(boxes=torch.tensor(rows, dtype=torch.float32).reshape(-1, 7 if ids else 6))

    # Its own description of a network, with random weights: nothing is fetched.
    model = YOLO("yolo11n.yaml", task="detect")
    model.add_callback("on_predict_postprocess_end", found)
    results = list(model.predict(video, stream=True, imgsz=64, device="cpu", verbose=False, **params))
    assert len(results) == FRAMES
    return results


def ultralytics_predict(format: str, path: Path) -> Any:
    """Label files of ``save_txt``, on request with ``conf`` and ``track``, and its ``data.yaml``."""
    from ultralytics.utils import YAML

    video, by_frame = _given()
    asked = format.split()
    _predicted(
        video, by_frame, "track" in asked, save_txt=True, save_conf="conf" in asked, project=str(path), name="predict"
    )
    YAML.save(path / "predict" / "data.yaml", {"path": ".", "names": dict(enumerate(CLASSES))})
    return {"files": sorted(file.name for file in (path / "predict" / "labels").iterdir())}


def ultralytics_results(format: str, path: Path) -> Any:
    """Tables of the results; they lack frame numbers, so a loop adds them, as users do."""
    video, by_frame = _given()
    results = _predicted(video, by_frame, True)
    if format == "json":
        rows = [{"frame": k, **row} for k, result in enumerate(results) for row in json.loads(result.to_json())]
        path.write_text(json.dumps(rows))
    elif format == "summary":
        path.write_text(json.dumps([{"frame": k, **row} for k, r in enumerate(results) for row in r.summary()]))
    elif format == "list":
        path.write_text(json.dumps([result.summary() for result in results]))
    elif format == "csv":
        text = ""
        for k, result in enumerate(results):
            header, *lines = result.to_csv().splitlines() if len(result) else [""]
            text += ("" if text or not lines else f"frame,{header}\n") + "".join(f"{k},{line}\n" for line in lines)
        path.write_text(text)
    else:
        import polars as pl

        tables = [
            result.to_df().with_columns(frame=pl.lit(k)).unnest("box")
            for k, result in enumerate(results)
            if len(result)
        ]
        pl.concat(tables).write_csv(path)
    return {}


# ---------------------------------------------------------------------------------------------------------- pycocotools


def pycocotools_results(format: str, path: Path) -> Any:
    """``loadRes`` of bare results, written again: whole (``dataset``) or as a list (``list``)."""
    from pycocotools.coco import COCO

    truth = COCO(str(path / "annotations" / "instances_default.json"))
    rows = [
        {key: note[key] for key in ("image_id", "category_id", "bbox")} | {"score": 0.75}
        for note in truth.dataset["annotations"]
    ]
    loaded = truth.loadRes(rows)
    content = loaded.dataset if format == "dataset" else loaded.loadAnns(loaded.getAnnIds())
    (path / "loaded.json").write_text(json.dumps(content))
    return {}


# ----------------------------------------------------------------------------------------------------- label_studio_sdk

_CONFIG = """<View>
  <Labels name="labels" toName="video"><Label value="stop"/><Label value="yield"/><Label value="50 km/h"/></Labels>
  <Video name="video" value="$video" framerate="25.0"/>
  <VideoRectangle name="box" toName="video"/>
</View>"""


def _sequences(by_frame: dict[int, list[Any]]) -> dict[tuple[int, str], list[dict[str, Any]]]:
    """Key frames of each track, frames from 1; ``enabled`` is false before a gap and at the end."""
    found: dict[tuple[int, str], list[dict[str, Any]]] = {}
    for frame, rows in sorted(by_frame.items()):
        for _, name, x1, y1, x2, y2, said in rows:
            found.setdefault((said["track_id"], name), []).append(
                {
                    "x": x1 / WIDTH * 100,
                    "y": y1 / HEIGHT * 100,
                    "width": (x2 - x1) / WIDTH * 100,
                    "height": (y2 - y1) / HEIGHT * 100,
                    "rotation": 0,
                    "frame": frame + 1,
                    "time": (frame + 1) / RATE,
                }
            )
    for keys in found.values():
        for key, following in zip(keys, [*keys[1:], None], strict=True):
            key["enabled"] = following is not None and following["frame"] == key["frame"] + 1
    return found


def _drawn(keys: list[dict[str, Any]]) -> bool:
    """Whether interpolation gives the middle one of three key frames."""
    if len(keys) < 3 or not keys[0]["enabled"] or not keys[1]["enabled"]:
        return False
    before, key, after = keys
    return all(
        abs(key[side] * 2 - before[side] - after[side]) < 1e-9 for side in ("x", "y", "width", "height", "frame")
    )


def label_studio_sdk_task(format: str, path: Path) -> Any:
    """Tasks from the object model of the SDK, and exports of its converter.

    ``json``, ``predictions``: tasks. ``frames``: with the interpolated frames, as an export with
    ``interpolate_key_frames``. ``JSON_MIN``, ``CSV``, ``TSV``: by the converter.
    """
    from label_studio_sdk._extensions.label_studio_tools.postprocessing.video import extract_key_frames
    from label_studio_sdk.converter import Converter
    from label_studio_sdk.label_interface import LabelInterface
    from label_studio_sdk.label_interface.objects import AnnotationValue, PredictionValue, TaskValue

    video, by_frame = _given()
    interface = LabelInterface(_CONFIG)
    control, about = interface.get_control("box"), interface.get_object("video")
    regions = [
        {
            "id": f"region{number}",
            "type": control.tag.lower(),
            "from_name": control.name,
            "to_name": about.name,
            "value": {"framesCount": FRAMES, "duration": FRAMES / RATE, "sequence": keys, "labels": [name]},
        }
        for (number, name), keys in _sequences(by_frame).items()
    ]
    if format == "frames":
        # Frames on a straight line between their neighbours are left out; the SDK interpolates them.
        for region in regions:
            keys = region["value"]["sequence"]
            region["value"]["sequence"] = [key for k, key in enumerate(keys) if not _drawn(keys[max(k - 1, 0) : k + 2])]
        regions = extract_key_frames(regions)
    data = {"video": f"/data/upload/1/0123abcd-{Path(video).name}"}
    task = (
        TaskValue(data=data, predictions=[PredictionValue(model_version="m", score=0.5, result=regions)])
        if format == "predictions"
        else TaskValue(data=data, annotations=[AnnotationValue(completed_by=1, result=regions)])
    )
    # Fields that the server adds to the task and its annotation.
    server = {"id": 1, "file_upload": Path(data["video"]).name, "project": 1}
    times = {"id": 1, "created_at": "2026-01-01T00:00:00Z", "updated_at": "2026-01-01T00:00:00Z", "lead_time": 1.0}
    whole = task.model_dump(mode="json") | server
    whole["annotations"] = [note | times for note in whole["annotations"]]
    tasks = path.with_name("tasks.json") if format.isupper() else path
    tasks.write_text(json.dumps([whole]))
    if format.isupper():
        made = path.with_name("converted")
        Converter(_CONFIG, str(path.parent)).convert(str(tasks), str(made), format, is_dir=False)
        (written,) = (file for file in made.iterdir() if file.is_file())
        written.rename(path)
    return {}


def label_studio_sdk_images(format: str, path: Path) -> Any:
    """Exports of its converter for a project of pictures, the frames of a video: COCO, YOLO or VOC."""
    from label_studio_sdk.converter import Converter

    _, by_frame = _given()
    labels = "".join(f'<Label value="{name}"/>' for name in CLASSES)
    config = (
        f'<View><Image name="image" value="$image"/><RectangleLabels name="label" toName="image">{labels}'
        "</RectangleLabels></View>"
    )
    tasks = []
    for frame in range(FRAMES):
        regions = [
            {
                "id": f"r{index}",
                "type": "rectanglelabels",
                "from_name": "label",
                "to_name": "image",
                "original_width": WIDTH,
                "original_height": HEIGHT,
                "value": {
                    "x": x1 / WIDTH * 100,
                    "y": y1 / HEIGHT * 100,
                    "width": (x2 - x1) / WIDTH * 100,
                    "height": (y2 - y1) / HEIGHT * 100,
                    "rotation": 0,
                    "rectanglelabels": [name],
                },
            }
            for index, (_, name, x1, y1, x2, y2, _) in enumerate(by_frame.get(frame, []))
        ]
        upload = f"{frame + 0xA0B0C0D0:08x}-frame_{frame:06d}.jpg"
        note = {"id": frame, "completed_by": 1, "result": regions, "created_at": "", "updated_at": "", "lead_time": 1.0}
        tasks.append({"id": frame, "data": {"image": f"/data/upload/1/{upload}"}, "annotations": [note]})
    path.mkdir()
    given = path.with_name("tasks.json")
    given.write_text(json.dumps(tasks))
    # The pictures are missing and not needed: the tasks have their sizes.
    Converter(config, str(path.parent), download_resources=False).convert(str(given), str(path), format, is_dir=False)
    return {}


def label_studio_sdk_label(_format: str, path: Path) -> Any:
    """A region of ``VideoRectangleTag.label``; its value has no ``enabled``."""
    from label_studio_sdk.label_interface import LabelInterface
    from label_studio_sdk.label_interface.objects import PredictionValue, TaskValue

    video, by_frame = _given()
    control = LabelInterface(_CONFIG).get_control("box")
    regions = [
        control.label(framesCount=FRAMES, duration=FRAMES / RATE, sequence=keys, labels=[name])
        for (_, name), keys in _sequences(by_frame).items()
    ]
    task = TaskValue(data={"video": Path(video).name}, predictions=[PredictionValue(result=regions)])
    path.write_text(json.dumps([task.model_dump(mode="json")]))
    return {}
