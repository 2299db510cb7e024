"""Fig. 9: precision and recall on scenes that nothing was trained on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.drawing import drawing
from benchmarks.experiment import Data, Experiment, Result, Skip, machine, table
from tsr_engine.detection.nms import suppress
from tsr_engine.detection.prior import SpatialPrior, parzen, with_prior
from tsr_engine.evaluation.detection import DetectionScore, score_detections
from tsr_engine.io.gtsdb import read_gtsdb
from tsr_engine.io.models import load_component
from tsr_engine.io.pictures import read_picture
from tsr_engine.params import Params
from tsr_engine.training.offline import BANDWIDTH, split_scenes

__all__ = ["EXPERIMENT"]


def _run(data: Data) -> Result:
    detector, prior = load_component("detector"), load_component("prior")
    seed = detector.seed or 0
    scenes = read_gtsdb(data.need("gtsdb"))
    train, calibrate, report = split_scenes(scenes, seed)
    rows = detector.arrays["heldout_boxes"].astype(float)
    raw = detector.arrays["heldout_raw"].astype(float)
    scene_of, boxes = rows[:, 0].astype(int), rows[:, 1:]
    known = detector.data["figures_from"]
    if (known["calibrated_on"], known["reported_on"]) != (len(calibrate), len(report)):
        raise Skip(f"the models report on {known['reported_on']} scenes of another folder than this one.")
    height, width = read_picture(scenes[0].path).shape[:2]
    found = np.concatenate([s.boxes for s in train])
    centres = np.stack([(found[:, 0] + found[:, 2]) / (2 * width), (found[:, 1] + found[:, 3]) / (2 * height)], axis=1)
    values = SpatialPrior(parzen(centres, BANDWIDTH), 0.0).at(boxes, width, height)
    overlap = Params().detector.final_overlap
    curves: dict[str, DetectionScore] = {}
    for name, weight in (("ACF", 0.0), ("ACF and prior", float(prior.params["lambda"]))):
        results = []
        for number, scene in enumerate(report):
            here = np.flatnonzero(scene_of == len(calibrate) + number)
            scores = with_prior(raw[here], values[here], weight)
            kept = suppress(boxes[here], scores, overlap)
            results.append((boxes[here][kept], scores[kept], scene.boxes))
        curves[name] = score_detections(results)
    return Result(
        "detection",
        data=f"GTSDB, split by scene: trained on {len(train)}, calibrated on {len(calibrate)}, reported on the "
        f"{len(report)} others ({curves['ACF'].signs} signs, all 43 classes as one, IoU 0.5). The detections are those "
        "that training kept of its model before it was trained once more on all scenes.",
        figures={name: _plain(curve) for name, curve in curves.items()},
        settings={"seed": seed, "detector": detector.sha256[:12], "prior": prior.sha256[:12]},
        machine=machine(),
    )


def _plain(curve: DetectionScore) -> dict[str, Any]:
    some = np.unique(np.linspace(0, len(curve.recall) - 1, 400).astype(int))
    return {
        "ap": curve.average_precision,
        "recall_at": {str(rate): curve.recall_at(rate) for rate in (0.03, 0.1, 1.0)},
        "recall": np.round(curve.recall[some], 5).tolist(),
        "precision": np.round(curve.precision[some], 5).tolist(),
    }


def _tell(result: Result) -> str:
    rows = [["", "AP", "recall at 0.03 false a picture", "at 0.1", "at 1"]]
    for name in ("ACF", "ACF and prior"):
        f = result.figures[name]
        rows.append([name, f"{f['ap']:.4f}", *(f"{f['recall_at'][rate]:.3f}" for rate in ("0.03", "0.1", "1.0"))])
    rows.append(["*bar*", "*0.98, aim 0.995*", "*0.95*", "", ""])
    return table(rows) + (
        "\nThe HOG cascade of the paper's figure and its two curves with the Kalman filter need other detectors and "
        "annotated video of such length; they are not measured here. The filter's effect is under *Real clips*.\n"
    )


def _plot(result: Result, path: Path) -> None:
    with drawing(path) as axes:
        for name, style in (("ACF", "--"), ("ACF and prior", "-")):
            f = result.figures[name]
            axes.plot(f["recall"], f["precision"], style, label=f"{name} (AP {f['ap']:.3f})")
        axes.set(xlabel="recall", ylabel="precision", xlim=(0.6, 1.005), ylim=(0, 1.02))
        axes.legend(loc="lower left")


EXPERIMENT = Experiment(
    "detection",
    "Detection on unseen scenes (Fig. 9)",
    "How many signs does the offline detector find, at how many false ones, with and without the spatial prior?",
    _run,
    _tell,
    _plot,
)
