"""Signs outside the 43 classes: found by cross-validation, found in pictures of other countries, and the price."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from benchmarks.boxes import lies_elsewhere
from benchmarks.experiment import ROOT, Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import table
from benchmarks.timing.alternating import scenes_in_turn
from tsr_engine.detection.other_shapes import COMPONENT, OtherShapes
from tsr_engine.evaluation.detection import match
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.io.models import component_path, load_component
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.classes import default_keys
from tsr_engine.params import Params
from tsr_engine.pipeline import load_detector, load_other_shapes, load_reader, one_blas_thread, one_opencv_thread
from tsr_engine.protocols import CropClassifier, OfflineDetector
from tsr_engine.recognition.crops import cut
from tsr_engine.records import FloatArray, Picture

SIZE: Final = (1280, 720)
PICTURES: Final = 24
TURNS: Final = 3
MIN_SIGN_PX: Final = 20
"""Signs whose longer side is shorter are neither hits nor misses, px."""
RATE: Final = 0.2
"""False detections a picture at which signs are counted once more."""
CLASSES: Final = {
    "I-5.1": "road-narrows-on-the-right", "I-10": "uneven-road", "II-1": "give-way", "II-2": "stop",
    "II-3": "no-vehicles", "II-7": "no-lorries", "II-7.1": "no-lorries", "II-30-30": "speed-limit-30",
    "II-47": "keep-right", "II-48": "roundabout",
}  # fmt: skip
"""Codes of the Slovenian catalogue whose signs are of the 43 classes, whatever colour their ground has."""
OTHERS: Final = {
    "III-6": "pedestrian-crossing", "II-34": "no-stopping", "II-40": "cycle-track", "II-45.1": "turn-right-here",
    "II-45.2": "turn-left-here", "II-33": "priority-for-oncoming-traffic", "III-35": "parking",
    "III-8-1": "no-through-road", "III-27": "no-parking-zone", "III-2": "one-way",
}  # fmt: skip
"""Codes of upright signs that the label set ``vienna`` has and the 43 classes lack. Boards and plates are neither."""
UNANNOTATED: Final = ROOT / "data" / "unannotated_signs.json"
"""Signs beside the annotations of the pictures abroad, as somebody saw them who looked at every detection on none."""


@dataclass(frozen=True, slots=True)
class Sign:
    """One annotated place.

    Attributes:
        box: shape (4,), px.
        kind: ``43``, ``other``, or empty: neither a hit nor a miss.
        name: code or name in the annotation.
        class_id: of the 43 classes; -1: of none.
        too_small: whether it is neither a hit nor a miss only because it is smaller than ``MIN_SIGN_PX``.
    """

    box: FloatArray
    kind: str
    name: str
    class_id: int = -1
    too_small: bool = False


def read_boxes(folder: Path) -> dict[str, list[Sign]]:
    """Annotated places by picture: of ``boxes.json`` with codes and ``bbox``, or with names, ``gtsrb`` and ``box``.

    Raises:
        Skip: there is no ``boxes.json``, or it is of another form.
    """
    try:
        rows = json.loads((folder / "boxes.json").read_text(encoding="utf-8"))
        signs: dict[str, list[Sign]] = {path.name: [] for path in sorted(folder.iterdir()) if path.suffix != ".json"}
        for row in rows:
            signs[row["file"]].append(_by_code(row) if "bbox" in row else _by_name(row))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise Skip(f"{folder / 'boxes.json'} cannot be read: {error!r}.") from None
    return signs


def _by_code(row: JsonMapping) -> Sign:
    x, y, width, height = (float(v) for v in row["bbox"])
    kind = "43" if row["code"] in CLASSES else "other" if row["code"] in OTHERS else ""
    class_id = default_keys().index(CLASSES[row["code"]]) if row["code"] in CLASSES else -1
    return _sign(np.array([x, y, x + width, y + height]), kind, not row["ignore"], row["code"], class_id)


def _by_name(row: JsonMapping) -> Sign:
    box = np.array(row["box"], np.float64)
    kind = "43" if row["gtsrb"] >= 0 else "other"
    return _sign(box, kind, not row["ignore"] and row["kind"] == "upright", row["name"], row["gtsrb"])


def _sign(box: FloatArray, kind: str, counted: bool, name: str, class_id: int) -> Sign:
    large = bool((box[2:] - box[:2]).max() >= MIN_SIGN_PX)
    return Sign(box, kind if counted and large else "", name, class_id, counted and bool(kind) and not large)


def read_unannotated(folder: str) -> dict[str, list[Sign]]:
    """Signs by picture that the annotations of a folder lack, as ``UNANNOTATED`` has them; neither hits nor misses."""
    signs: dict[str, list[Sign]] = {}
    for row in json.loads(UNANNOTATED.read_text(encoding="utf-8")):
        if row["folder"] == folder:
            signs.setdefault(row["file"], []).append(Sign(np.array(row["box"], np.float64), "", row["what"]))
    return signs


def counts(pictures: Sequence[tuple[Sequence[Sign], FloatArray, FloatArray]]) -> dict[str, int]:
    """Signs of both kinds, those found at IoU 0.5, and detections on no annotated place.

    ``_at_rate`` counts those found from the score on at which ``RATE`` false detections a picture are left.

    Args:
        pictures: for each its signs, and boxes (n, 4) and scores (n,) of the detections.
    """
    out = {"43": 0, "43_found": 0, "other": 0, "other_found": 0, "pictures": len(pictures)}
    hits: list[tuple[str, float]] = []
    false: list[float] = []
    for signs, boxes, scores in pictures:
        truth = np.array([sign.box for sign in signs]).reshape(-1, 4)
        _, found = match(boxes, scores, truth)
        for sign, by in zip(signs, found, strict=True):
            if sign.kind:
                out[sign.kind] += 1
                out[f"{sign.kind}_found"] += bool(by >= 0)
                hits += [(sign.kind, float(scores[by]))] if by >= 0 else []
        false += scores[lies_elsewhere(boxes, truth)].tolist()
    false.sort(reverse=True)
    allowed = int(RATE * len(pictures))
    above = false[allowed] if allowed < len(false) else -np.inf
    for kind in ("43", "other"):
        out[f"{kind}_at_rate"] = sum(score > above for own, score in hits if own == kind)
    return {**out, "false": len(false)}


def _run(data: Data) -> Result:
    params = Params().with_settings([("second_core", False)])
    component = load_component(COMPONENT)
    cv = component.figures
    with one_opencv_thread(), one_blas_thread():
        detector, others, reader = load_detector(params), load_other_shapes(params), load_reader()
        price = _cost(detector, others, data)
        foreign = {
            folder.name: {**_foreign(detector, others, folder), "read": read_signs(detector, reader, folder)}
            for folder in sorted(data.foreign.iterdir() if data.foreign is not None else ())
            if (folder / "boxes.json").is_file()
        }
    return Result(
        data="GTSDB's training scenes with the annotations of other signs (docs/annotations-gtsdb.md): "
        f"{cv['signs']} upright signs from {MIN_SIGN_PX} px in {cv['pictures']} scenes, IoU 0.5. Each of "
        f"{component.data['figures_from']['parts']} parts of the scenes is tested with a model trained on the rest. "
        "Pictures of other countries are test data only; docs/models.md says which of them were looked at.",
        figures={
            "cross_validation": {**cv, "score": component.data["figures_from"]["score"]},
            "foreign": foreign,
            "price": price,
            "model_bytes": component_path(COMPONENT).stat().st_size,
        },
        settings={"seed": component.seed, "other_shapes": component.sha256[:12]},
    )


def _cost(detector: OfflineDetector, others: OtherShapes, data: Data) -> dict[str, float]:
    scenes = read_gtsdb(data.need("gtsdb"))
    chosen = scenes[:: max(1, len(scenes) // PICTURES)][:PICTURES]
    pictures: list[Picture] = [
        np.asarray(cv2.resize(read_picture(scene.path), SIZE, interpolation=cv2.INTER_AREA), np.uint8)
        for scene in chosen
    ]
    turns = scenes_in_turn(
        {"without": detector.detect, "with": lambda picture: others.detect(picture, detector.detect(picture))},
        pictures,
        TURNS,
    )
    ratio = turns.paired("with", "without")
    return {"without": turns.median("without"), "with": turns.median("with"), "ratio": ratio["median"]}


def _foreign(detector: OfflineDetector, others: OtherShapes, folder: Path) -> dict[str, JsonObject]:
    """Counts without and with the other shapes; ``looked_at``: without what lies on a sign that nobody annotated."""
    rows: dict[str, list[tuple[Sequence[Sign], FloatArray, FloatArray]]] = {"without": [], "with": []}
    looked_at: dict[str, list[tuple[Sequence[Sign], FloatArray, FloatArray]]] = {"without": [], "with": []}
    unannotated = read_unannotated(folder.name)
    for name, signs in read_boxes(folder).items():
        picture = read_picture(folder / name)
        known = detector.detect(picture)
        more = others.detect(picture, known)
        both = np.concatenate([known.boxes, more.boxes]), np.concatenate([known.raw_scores, more.raw_scores])
        for how, found in (("without", (known.boxes, known.raw_scores)), ("with", both)):
            rows[how].append((signs, *found))
            looked_at[how].append(([*signs, *unannotated.get(name, [])], *found))
    return {how: {**counts(pictures), "looked_at": counts(looked_at[how])} for how, pictures in rows.items()}


def read_signs(detector: OfflineDetector, reader: CropClassifier, folder: Path) -> dict[str, dict[str, int]]:
    """Signs of the 43 classes, found ones, and those read right at the detection: large ones, and of any size."""
    out = {size: {"signs": 0, "found": 0, "right": 0} for size in ("large", "any")}
    for name, signs in read_boxes(folder).items():
        picture = read_picture(folder / name)
        known = detector.detect(picture)
        _, found = match(known.boxes, known.raw_scores, np.array([sign.box for sign in signs]).reshape(-1, 4))
        for sign, by in zip(signs, found, strict=True):
            if sign.class_id < 0 or not (sign.kind or sign.too_small):
                continue
            right = False
            if by >= 0:
                crop = cut(picture, known.boxes[by], reader.margin)
                right = int(reader.probabilities([crop])[0].argmax()) == sign.class_id
            for size in ("any",) if sign.too_small else ("any", "large"):
                out[size]["signs"] += 1
                out[size]["found"] += bool(by >= 0)
                out[size]["right"] += right
    return out


def _report(result: Result) -> str:
    f = result.figures
    cv, price = f["cross_validation"], f["price"]
    head = ["pictures", "`--other-shapes`", "upright signs outside the 43", "signs of the 43"]
    for where in ("no annotated place", "no sign at all"):
        head += [f"detections on {where}, a picture", f"signs outside the 43 found at {RATE} of those a picture"]
    rows = [head]
    for name, found in f["foreign"].items():
        for how in ("without", "with"):
            one = found[how]
            rows.append([
                f"{name} ({one['pictures']})", how, f"{one['other_found']} of {one['other']}",
                f"{one['43_found']} of {one['43']}", *_at_rate(one), *_at_rate(one["looked_at"]),
            ])  # fmt: skip
    abroad = table(rows) if f["foreign"] else "*No pictures of other countries were named.*\n"
    columns = ["found", "read right"]
    read = [["pictures", f"signs of the 43 from {MIN_SIGN_PX} px", *columns, "of any size", *columns]]
    for name, found in f["foreign"].items():
        large, every = found["read"]["large"], found["read"]["any"]
        read.append([name, *(f"{one[key]}" for one in (large, every) for key in ("signs", "found", "right"))])
    return (
        f"Cross-validation: recall {cv['recall_at_0.2']:.3f} at 0.2 false detections a picture (log-odds from "
        f"{cv['score']:.2f}), {cv['recall_at_1']:.3f} at 1; AP {cv['ap50']:.3f}.\n\n"
        "The table counts what `tsr detect` finds without and with `--other-shapes`, at the score that keeps a "
        "detection. *On no sign at all* excludes detections on signs that nobody annotated; each of them was checked "
        f"by eye (`benchmarks/data/{UNANNOTATED.name}`):\n\n"
        f"{abroad}\n"
        "What is found of the 43 classes without the option, and read right by classifier and network at the "
        f"detected box:\n\n{table(read)}\n"
        f"Cost at {SIZE[0]}x{SIZE[1]}, one thread, CPU: {price['without']:.1f} ms without, {price['with']:.1f} ms "
        f"with (ratio {price['ratio']:.2f}). The model has {f['model_bytes'] / 1e6:.1f} MB and is loaded only with the "
        "option.\n"
    )


def _at_rate(one: JsonMapping) -> tuple[str, str]:
    return f"{one['false'] / max(1, one['pictures']):.2f}", f"{one['other_at_rate']} of {one['other']}"


def _headline(result: Result) -> str:
    price = result.figures["price"]
    return f"{price['without']:.1f} ms without, {price['with']:.1f} ms with"


EXPERIMENT = Experiment(
    "other_shapes",
    "Signs outside the 43 classes",
    "How many upright signs of other classes does `--other-shapes` find, and what does it cost?",
    _run,
    _report,
    headline=_headline,
    optional=("foreign",),
)
