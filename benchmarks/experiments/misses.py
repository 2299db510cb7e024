"""Shows the signs that the offline detector misses on held-out scenes, as one sheet of pictures."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np

from benchmarks.experiment import ROOT, Data, Experiment, Result
from benchmarks.reporting.contact_sheet import Cell, write_sheet
from benchmarks.reporting.markdown import class_name, table
from benchmarks.systems.held_out_scenes import held_out
from tsr_engine.evaluation.detection import match, score_detections
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray, Picture

SHEET = ROOT / "figures" / "misses.png"
RATE = 0.03
"""False detections per picture at which the recall is measured."""
MARGIN = 0.6
"""Border around a sign in the sheet, as a share of its size on each side."""


class SceneDetections(NamedTuple):
    """A report scene with its detections: boxes (n, 4) after suppression, and scores (n,) with the prior."""

    scene: Scene
    boxes: FloatArray
    scores: FloatArray


def misses(seen: Sequence[SceneDetections], threshold: float) -> list[JsonObject]:
    """Signs without a detection of at least ``threshold`` at IoU 0.5, the smallest first.

    Returns:
        For each its ``picture``, ``sign``, ``class``, ``width`` and ``box``; the ``score`` of the best detection on it
        at IoU 0.5; the ``near`` score and ``overlap`` of the best detection with a smaller overlap (None: there is
        none).
    """
    found = []
    for number, one in enumerate(seen):
        kept = one.scores >= threshold
        _, taken = match(one.boxes[kept], one.scores[kept], one.scene.boxes)
        for sign in np.flatnonzero(taken < 0):
            box = one.scene.boxes[sign]
            overlap = iou(box, one.boxes)[0] if len(one.boxes) else np.zeros(0)
            on, near = overlap >= 0.5, (overlap > 0.1) & (overlap < 0.5) & kept
            found.append({
                "scene": number, "picture": one.scene.path.name, "sign": int(sign),
                "class": int(one.scene.class_ids[sign]), "width": float(box[2] - box[0]), "box": box.tolist(),
                "score": float(one.scores[on].max()) if on.any() else None,
                "near": float(one.scores[near].max()) if near.any() else None,
                "overlap": float(overlap[near].max()) if near.any() else None,
            })  # fmt: skip
    return sorted(found, key=lambda m: m["width"])


def reason(miss: JsonObject, contrast: float) -> str:
    """The reason in words why a sign was missed, from its detections.

    Args:
        miss: see ``misses``.
        contrast: standard deviation of the sign's brightness, grey values of 255.
    """
    if miss["near"] is not None:
        return f"found, but its box overlaps by {miss['overlap']:.2f} only"
    parts = []
    if miss["width"] < 20:
        parts.append("small")
    if contrast < 25:
        parts.append("low contrast")
    if miss["score"] is not None:
        parts.append(f"scored {miss['score']:.2f}")
    else:
        parts.append("no window on it")
    return ", ".join(parts)


def _run(data: Data) -> Result:
    known = held_out(data)
    found = known.detections(prior=True)
    seen = [
        SceneDetections(scene, boxes, scores) for scene, (boxes, scores, _) in zip(known.report, found, strict=True)
    ]
    score = score_detections(found)
    threshold = score.threshold_at(RATE)
    missed = misses(seen, threshold)
    cells = []
    for number, miss in enumerate(missed, 1):
        picture = read_picture(seen[miss["scene"]].scene.path)
        miss["contrast"] = _contrast(picture, np.array(miss["box"]))
        cells.append(Cell(str(number), picture, np.array(miss["box"])))
    false = _false(seen, threshold)
    cells += [
        Cell(f"F{i}", read_picture(seen[f["scene"]].scene.path), np.array(f["box"])) for i, f in enumerate(false, 1)
    ]
    write_sheet(SHEET, cells, margin=MARGIN)
    signs = [(one.scene.boxes[:, 2] - one.scene.boxes[:, 0]) for one in seen]
    return Result(
        data=f"The {len(seen)} report scenes of GTSDB, with the stored detections of the model that was trained "
        "without them.",
        figures={
            "threshold": threshold,
            "signs": score.signs,
            "missed": [{k: v for k, v in m.items() if k not in ("scene", "box")} for m in missed],
            "false": [{k: v for k, v in f.items() if k not in ("scene", "box")} for f in false],
            "by_width": _by_width(np.concatenate(signs), [m["width"] for m in missed]),
        },
        settings={"false_a_picture": RATE},
    )


def _false(seen: Sequence[SceneDetections], threshold: float) -> list[JsonObject]:
    """Detections of at least the threshold that lie on no sign, the highest score first."""
    out = []
    for number, one in enumerate(seen):
        kept = one.scores >= threshold
        boxes, scores = one.boxes[kept], one.scores[kept]
        hit, _ = match(boxes, scores, one.scene.boxes)
        out += [
            {"scene": number, "picture": one.scene.path.name, "score": float(scores[i]), "box": boxes[i].tolist()}
            for i in np.flatnonzero(~hit)
        ]
    return sorted(out, key=lambda f: -f["score"])


def _contrast(picture: Picture, box: FloatArray) -> float:
    x1, y1, x2, y2 = (max(0, round(float(v))) for v in box)
    return float(cv2.cvtColor(picture[y1:y2, x1:x2], cv2.COLOR_BGR2GRAY).std())


def _by_width(all_widths: FloatArray, missed: Sequence[float]) -> list[JsonObject]:
    edges = (0, 20, 24, 32, 48, 1000)
    return [
        {
            "from": low, "to": high, "signs": int(((all_widths >= low) & (all_widths < high)).sum()),
            "missed": sum(low <= width < high for width in missed),
        }
        for low, high in pairwise(edges)
    ]  # fmt: skip


def _report(result: Result) -> str:
    f = result.figures
    bins = [
        ["width, px", *(f"{b['from']} to {b['to']}" if b["to"] < 1000 else f"from {b['from']}" for b in f["by_width"])]
    ]
    bins.append(["signs", *(str(b["signs"]) for b in f["by_width"])])
    bins.append(["missed", *(str(b["missed"]) for b in f["by_width"])])
    rows = [["", "scene", "sign", "width, px", "why"]]
    for number, m in enumerate(f["missed"], 1):
        rows.append([
            str(number), m["picture"], class_name(m["class"]), f"{m['width']:.0f}", reason(m, m["contrast"])
        ])  # fmt: skip
    return "\n".join((
        f"At {RATE} false detections a picture (score {f['threshold']:.2f}) {len(f['missed'])} of {f['signs']} signs "
        f"are missed, and {len(f['false'])} detections lie on no annotated sign (F in the sheet). Detections on "
        "signs of none of the 43 classes or on signs that the annotation lacks count as false too, so look at the "
        "pictures before you trust the rate.\n",
        table(bins),
        f"![Missed signs](figures/{SHEET.name})\n",
        table(rows),
    ))  # fmt: skip


EXPERIMENT = Experiment(
    "misses",
    "Missed signs, with pictures",
    "Which signs of unseen scenes are missed at the false-detection rate of the bar, and why?",
    _run,
    _report,
)
