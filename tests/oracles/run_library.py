"""Runs in the environment of the other libraries: reads or writes a data set with one of them, in JSON.

Called as ``python run_library.py LIBRARY ACTION FORMAT PATH``; the data to write comes as JSON on standard input. A box
is ``[frame, class name, x1, y1, x2, y2, attributes]`` in px edges from 0.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import run_video_library

WIDTH, HEIGHT, FRAMES = 64, 48, 20
CLASSES = ["stop", "yield", "50 km/h"]


def frame_of(name: object) -> int:
    return int(re.findall(r"\d+", Path(str(name)).stem)[-1])


# ------------------------------------------------------------------------------------------------------------ datumaro


def datumaro_read(format: str, path: Path) -> Any:
    import datumaro as dm

    dataset = dm.Dataset.import_from(str(path), format)
    names = [label.name for label in dataset.categories()[dm.AnnotationType.label]]
    boxes = []
    for item in dataset:
        for box in item.annotations:
            if box.type == dm.AnnotationType.bbox:
                x, y, w, h = box.get_bbox()
                attributes = {
                    key: value for key, value in box.attributes.items() if isinstance(value, bool | int | float | str)
                }
                frame = item.attributes.get("frame")
                if format == "mot_seq":
                    # Datumaro keeps the numbers of the file, which count from 1.
                    frame = frame_of(item.id) - 1
                boxes.append(
                    [frame_of(item.id) if frame is None else frame, names[box.label], x, y, x + w, y + h, attributes]
                )
    return {"boxes": boxes, "items": len(dataset)}


def datumaro_write(format: str, path: Path) -> Any:
    import datumaro as dm
    import numpy as np

    boxes = json.load(sys.stdin)
    by_frame: dict[int, list[Any]] = {}
    for frame, name, x1, y1, x2, y2, said in boxes:
        by_frame.setdefault(frame, []).append(
            dm.Bbox(x1, y1, x2 - x1, y2 - y1, label=CLASSES.index(name), attributes=said)
        )
    items = [
        dm.DatasetItem(
            id=f"frame_{frame:06d}",
            annotations=notes,
            attributes={"frame": frame},
            media=dm.Image.from_numpy(data=np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)),
        )
        for frame, notes in ((frame, by_frame.get(frame, [])) for frame in range(FRAMES))
    ]
    dm.Dataset.from_iterable(items, categories=CLASSES, media_type=dm.Image).export(str(path), format, save_media=True)
    return {}


# --------------------------------------------------------------------------------------------------------- supervision


def _supervision(format: str, path: Path) -> Any:
    import supervision as sv

    if format == "coco":
        return sv.DetectionDataset.from_coco(
            str(path / "images" / "default"), str(path / "annotations" / "instances_default.json")
        )
    if format == "yolo":
        return sv.DetectionDataset.from_yolo(
            str(path / "images" / "train"), str(path / "labels" / "train"), str(path / "data.yaml")
        )
    return sv.DetectionDataset.from_pascal_voc(str(path / "JPEGImages"), str(path / "Annotations"))


def supervision_read(format: str, path: Path) -> Any:
    dataset = _supervision(format, path)
    boxes = []
    for name, _, found in dataset:
        for edges, label in zip(found.xyxy.tolist(), found.class_id.tolist(), strict=True):
            boxes.append([frame_of(name), dataset.classes[label], *edges, {}])
    return {"boxes": boxes}


def supervision_write(format: str, path: Path) -> Any:
    import numpy as np
    import supervision as sv

    by_frame: dict[str, list[Any]] = {}
    for frame, name, *edges, _ in json.load(sys.stdin):
        by_frame.setdefault(f"frame_{frame:06d}.jpg", []).append((edges, CLASSES.index(name)))
    images = {name: np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8) for name in by_frame}
    found = {
        name: sv.Detections(
            xyxy=np.array([edges for edges, _ in rows], dtype=np.float64), class_id=np.array([c for _, c in rows])
        )
        for name, rows in by_frame.items()
    }
    dataset = sv.DetectionDataset(CLASSES, images, found)
    if format == "coco":
        dataset.as_coco(str(path / "images"), str(path / "annotations" / "instances_default.json"))
    elif format == "yolo":
        dataset.as_yolo(str(path / "images"), str(path / "labels"), str(path / "data.yaml"))
    else:
        dataset.as_pascal_voc(str(path / "JPEGImages"), str(path / "Annotations"))
    return {}


# ---------------------------------------------------------------------------------------------------------- pycocotools


def pycocotools_read(_format: str, path: Path) -> Any:
    """Boxes, and the precision of the annotations scored as results, which must be 1."""
    from pycocotools.coco import COCO
    from pycocotools.cocoeval import COCOeval

    truth = COCO(str(path / "annotations" / "instances_default.json"))
    boxes, results = [], []
    for note in truth.dataset["annotations"]:
        image, (x, y, w, h) = truth.imgs[note["image_id"]], note["bbox"]
        name = truth.cats[note["category_id"]]["name"]
        boxes.append([image["frame"], name, x, y, x + w, y + h, note["attributes"]])
        results.append(
            {"image_id": note["image_id"], "category_id": note["category_id"], "bbox": note["bbox"], "score": 1.0}
        )
    score = COCOeval(truth, truth.loadRes(results), "bbox")
    score.evaluate()
    score.accumulate()
    score.summarize()
    (path / "results.json").write_text(json.dumps(results))
    return {"boxes": boxes, "ap": float(score.stats[0])}


# --------------------------------------------------------------------------------------------------------------- globox


def globox_read(format: str, path: Path) -> Any:
    import globox

    if format == "coco":
        found = globox.AnnotationSet.from_coco(file_path=path / "annotations" / "instances_default.json")
    elif format == "yolo":
        from yaml import safe_load

        names = safe_load((path / "data.yaml").read_text(encoding="utf-8"))["names"]
        found = globox.AnnotationSet.from_yolo_v5(
            folder=path / "labels" / "train", image_folder=path / "images" / "train"
        ).map_labels({str(number): name for number, name in names.items()})
    elif format == "cvat":
        found = globox.AnnotationSet.from_cvat(file_path=path / "annotations.xml")
    else:
        found = globox.AnnotationSet.from_pascal_voc(folder=path / "Annotations")
    return {
        "boxes": [
            [frame_of(a.image_id), box.label, box.xmin, box.ymin, box.xmax, box.ymax, {}]
            for a in found
            for box in a.boxes
        ]
    }


def globox_write(format: str, path: Path) -> Any:
    import globox

    by_frame: dict[int, list[Any]] = {}
    for frame, name, *edges, _ in json.load(sys.stdin):
        by_frame.setdefault(frame, []).append(
            globox.BoundingBox(label=name, xmin=edges[0], ymin=edges[1], xmax=edges[2], ymax=edges[3])
        )
    found = globox.AnnotationSet(
        [globox.Annotation(f"frame_{frame:06d}.jpg", (WIDTH, HEIGHT), boxes) for frame, boxes in by_frame.items()]
    )
    numbers = {name: index for index, name in enumerate(CLASSES)}
    path.mkdir(parents=True, exist_ok=True)
    if format == "coco":
        found.save_coco(
            path / "annotations.json", label_to_id={name: n + 1 for name, n in numbers.items()}, auto_ids=True
        )
    elif format == "yolo":
        found.save_yolo_v5(path / "labels", label_to_id=numbers)
        (path / "data.yaml").write_text(f"names: {CLASSES}\n", encoding="utf-8")
    elif format == "cvat":
        found.save_cvat(path / "annotations.xml")
    else:
        found.save_pascal_voc(path / "Annotations")
    return {}


# ------------------------------------------------------------------------------------------------------- MOT libraries


def motmetrics_read(_format: str, path: Path) -> Any:
    import motmetrics

    table = motmetrics.io.loadtxt(str(path / "gt" / "gt.txt"), fmt="mot16")
    names = (path / "gt" / "labels.txt").read_text(encoding="utf-8").splitlines()
    boxes = []
    for (frame, track), row in table.iterrows():
        name = names[int(row.ClassId) - 1]
        said = {"track": int(track)}
        boxes.append([frame - 1, name, row.X, row.Y, row.X + row.Width, row.Y + row.Height, said])
    return {"boxes": boxes}


def trackeval_score(_format: str, path: Path) -> Any:
    """Our ground truth scored against itself, figures in 0 to 1."""
    import contextlib
    import io
    import shutil

    import trackeval

    name = "drive"
    truth = path / "work" / "gt" / "MOT-train" / name
    shutil.copytree(path / "sequence", truth)
    results = path / "work" / "trackers" / "MOT-train" / "self" / "data"
    results.mkdir(parents=True)
    rows = []
    for line in (truth / "gt" / "gt.txt").read_text().splitlines():
        frame, track, x, y, w, h, *_ = line.split(",")
        rows.append(f"{frame},{track},{x},{y},{w},{h},1,-1,-1,-1\n")
    (results / f"{name}.txt").write_text("".join(rows))
    with contextlib.redirect_stdout(io.StringIO()):
        data = trackeval.datasets.MotChallenge2DBox(
            {
                "GT_FOLDER": str(path / "work" / "gt"),
                "TRACKERS_FOLDER": str(path / "work" / "trackers"),
                "TRACKERS_TO_EVAL": ["self"],
                "BENCHMARK": "MOT",
                "SPLIT_TO_EVAL": "train",
                "SEQ_INFO": {name: None},
                "DO_PREPROC": False,
                "PRINT_CONFIG": False,
            }
        )
        raw = data.get_raw_seq_data("self", name)
        prepared = data.get_preprocessed_seq_data(raw, "pedestrian")
        hota = trackeval.metrics.HOTA().eval_sequence(prepared)
        clear = trackeval.metrics.CLEAR({"PRINT_CONFIG": False}).eval_sequence(prepared)
        identity = trackeval.metrics.Identity({"PRINT_CONFIG": False}).eval_sequence(prepared)
    return {
        "boxes": len(rows),
        "counted": int(clear["CLR_TP"]),
        "HOTA": float(hota["HOTA"].mean()),
        "MOTA": float(clear["MOTA"]),
        "IDF1": float(identity["IDF1"]),
        "IDSW": int(clear["IDSW"]),
    }


# ---------------------------------------------------------------------------------------------------------- ultralytics


def ultralytics_check(_format: str, path: Path) -> Any:
    """Ultralytics' check of every label file, and the data set of its loader."""
    import numpy as np
    from ultralytics.data.dataset import YOLODataset
    from ultralytics.data.utils import check_det_dataset, verify_image_label

    data = check_det_dataset(str(path / "data.yaml"), autodownload=False)
    images = sorted(Path(data["train"]).iterdir())
    bad, found = [], 0
    for image in images:
        label = str(image).replace("/images/", "/labels/").rsplit(".", 1)[0] + ".txt"
        verdict = verify_image_label((str(image), label, "", False, len(data["names"]), 0, 0, False))
        found += len(verdict[1])
        bad += [str(verdict[-1])] if verdict[-1] or verdict[-2] else []
    loader = YOLODataset(img_path=data["train"], data=data, task="detect", augment=False, imgsz=64)
    boxes = []
    for label in loader.labels:
        height, width = label["shape"]
        for number, (cx, cy, w, h) in zip(label["cls"][:, 0], label["bboxes"], strict=True):
            edges = np.array([cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2]) * (width, height, width, height)
            boxes.append([frame_of(label["im_file"]), data["names"][int(number)], *edges.tolist(), {}])
    first = loader[0]
    return {
        "boxes": boxes,
        "bad": bad,
        "verified": found,
        "tensor": list(first["img"].shape),
        "names": {str(number): name for number, name in data["names"].items()},
    }


def main() -> None:
    library, action, name, path = sys.argv[1:5]
    out = sys.stdout
    # Libraries print; only the answer goes to the real standard output.
    sys.stdout = sys.stderr
    called = f"{library}_{action}"
    answer = (globals().get(called) or getattr(run_video_library, called))(name, Path(path))
    json.dump(answer, out, default=float)


if __name__ == "__main__":
    main()
