"""[47] of the paper's comparison: a small deep detector, trained from scratch on the same scenes as ours."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from benchmarks.experiment import Data, Experiment, Result, Skip
from benchmarks.reporting.markdown import table
from benchmarks.reporting.plotting import draw_precision_recall
from benchmarks.systems.curves import curve_figures
from benchmarks.systems.held_out_scenes import ACF_IS, DetectionResults, held_out
from benchmarks.timing.contenders import SIGNS
from tsr_engine.detection.onnx import Layout, OnnxDetector
from tsr_engine.evaluation.detection import DetectionScore, score_detections
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params.detector import DetectorParams

MIN_SCORE = -4.0
"""Log-odds from which its detections are kept; below, there are thousands of false ones."""
SIZES = ((16, 32), (32, 64), (64, 1000))
"""Widths of signs, px, that recall is reported for."""


def _run(data: Data) -> Result:
    data.need("gtsdb")
    about = SIGNS.with_suffix(".json")
    if not SIGNS.is_file() or not about.is_file():
        raise Skip(
            "there is no trained network; `python -m benchmarks.deep.train --gtsdb GTSDB --state out/deep.pt --out "
            f"benchmarks/deep/{SIGNS.name}` makes it (needs `torch` and `onnx`, extra `bench`)."
        )
    reported = json.loads(about.read_text(encoding="utf-8"))
    known = held_out(data)
    component, report = known.detector, known.report
    if reported["training"]["seed"] != (component.seed or 0):
        raise Skip("the network was trained on another split of the scenes than the shipped detector.")
    if reported["training"]["scenes"] != len(known.train):
        raise Skip(
            f"the network was trained on {reported['training']['scenes']} scenes, this folder's split has "
            f"{len(known.train)}."
        )
    network = plug_in(SIGNS, (int(reported["input"][0]), int(reported["input"][1])), reported["layout"])
    found = {"small deep detector": detect_scenes(network, report), "ACF": known.detections(prior=False)}
    return Result(
        data=f"GTSDB, split by scene as for *Detection on unseen scenes*: {len(known.train)} scenes train, the "
        f"{len(known.calibrate)} of calibration are unused, {len(report)} are reported on. Both detectors run without "
        "the prior, on pictures at full size; IoU 0.5, all classes as one.",
        figures={name: scene_figures(results) for name, results in found.items()}
        | {"training": reported["training"], "bytes": reported["bytes"]},
        settings={
            "input": "x".join(map(str, reported["input"])),
            "network": hashlib.sha256(SIGNS.read_bytes()).hexdigest()[:12],
            "detector": component.sha256[:12],
        },
    )


def plug_in(network: Path, size: tuple[int, int], layout: Layout = "v8", min_score: float = MIN_SCORE) -> OnnxDetector:
    """A network in the engine's plug-in, as `tsr track --onnx` uses it, without a prior."""
    return OnnxDetector(network.read_bytes(), size, layout, params=DetectorParams(keep_score=min_score))


def detect_scenes(detector: OnnxDetector, report: Sequence[Scene]) -> DetectionResults:
    """Detect in each scene."""
    results = []
    for scene in report:
        seen = detector.detect(read_picture(scene.path))
        results.append((seen.boxes, seen.raw_scores, scene.boxes))
    return results


def scene_figures(results: DetectionResults) -> JsonObject:
    """The curve of a detector, and the signs that it finds by width."""
    score = score_detections(results)
    return {**curve_figures(score), "by_width": _by_width(results, score)}


def _by_width(results: DetectionResults, score: DetectionScore) -> dict[str, list[int]]:
    """For each range of widths, signs found at one false detection in ten pictures, and number of signs."""
    least = score.threshold_at(0.1)
    counts = {}
    for low, high in SIZES:
        chosen = [
            (b[s >= least], s[s >= least], t[(t[:, 2] - t[:, 0] >= low) & (t[:, 2] - t[:, 0] < high)])
            for b, s, t in results
        ]
        part = score_detections(chosen)
        counts[f"{low}-{high}"] = [round(part.signs * float(part.recall[-1])) if len(part.recall) else 0, part.signs]
    return counts


def _report(result: Result) -> str:
    f = result.figures
    rows = [["", "AP", "recall at 0.03 false a picture", "at 0.1", "at 1", *_widths(f["ACF"])]]
    for name in ("ACF", "small deep detector"):
        recalls = (f"{f[name]['recall_at'][rate]:.3f}" for rate in ("0.03", "0.1", "1.0"))
        by_width = (f"{hit}/{signs}" for hit, signs in f[name]["by_width"].values())
        rows.append([name, f"{f[name]['ap']:.4f}", *recalls, *by_width])
    t = f["training"]
    return (
        table(rows) + ACF_IS + "\nThe last columns count the signs found at 0.1 false a picture, by width.\n\n"
        f"The network is convolutional and anchor-free: {t['parameters']:,} parameters ({f['bytes'] / 1e6:.1f} MB "
        "as ONNX), one output for each cell of 8 px. It was trained from random weights on one CPU core in "
        f"{t['cpu_minutes']} minutes of CPU time: {t['steps']:,} steps of {t['batch']} crops of {t['crop']} px. They "
        f"show each of the {t['signs']} signs {t['views_of_each_sign']:g} times, moved, scaled, mirrored and relit. "
        "OpenCV runs it through the plug-in of `--onnx`. ACF was trained on the same scenes and also on the crops of "
        "GTSRB, which the network has not seen. The figures show what such a network learns from so few scenes in so "
        "little time, not the limit of deep detectors: published ones start from weights trained on hundreds of "
        "thousands of pictures and train for hours on a GPU.\n"
    )


def _widths(figures: JsonObject) -> list[str]:
    return [f"{name} px".replace("-1000", " and more") for name in figures["by_width"]]


def _plot(result: Result, path: Path) -> None:
    draw_precision_recall(path, result.figures, {"small deep detector": "--", "ACF": "-"})


EXPERIMENT = Experiment(
    "deep",
    "A small deep detector ([47] of the paper's comparison)",
    "What does a deep detector learn from the scenes that our detector was trained on, within minutes of training?",
    _run,
    _report,
    _plot,
)
