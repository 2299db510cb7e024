"""Fig. 13: classification over the number of fused frames."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.drawing import drawing
from benchmarks.experiment import Data, Experiment, Result, machine, table
from tsr_engine.evaluation.fusion import MODES, evaluate_fusion, track_votes
from tsr_engine.io.gtsrb import CropItem, read_items, read_picture, split_by_track
from tsr_engine.io.models import load_component, save_component
from tsr_engine.params import Params
from tsr_engine.pipeline import one_blas_thread
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.training.classifier import ClassifierSettings, train_classifier

__all__ = ["EXPERIMENT"]

SHOWN = (1, 2, 3, 5, 8, 12, 16, 20, 25, 30)
TIMED = 1000
"""Crops that are read one by one."""


def _run(data: Data) -> Result:
    folder = data.need("gtsrb")
    settings = ClassifierSettings(refit_steps=0)  # weights that have never seen the held-out tracks
    kept = data.scratch / f"classifier-split-{data.seed}"
    if not (kept / "manifest.json").is_file():
        save_component(train_classifier(folder, data.seed, settings), kept)
    component = load_component("classifier", kept)
    items = [item for item in read_items(folder) if item.track is not None]
    held = split_by_track(items, settings.held_out, data.seed)[1]
    classifier = SignClassifier.from_component(component)
    report = evaluate_fusion(track_votes(held, classifier), Params().fusion)
    return Result(
        "fusion",
        data=f"GTSRB training set, split by physical sign: {report.tracks} signs held out; the weights have seen only "
        "the others (the shipped ones went on to train on all).",
        figures={**report.as_dict(), "crop_ms": _crop_time(held, classifier)},
        settings={"seed": data.seed, "held_out": settings.held_out},
        machine=machine(),
    )


def _crop_time(items: Sequence[CropItem], classifier: SignClassifier) -> float:
    """Median CPU time of reading one crop, ms: cut out, scaled, described and judged by one thread."""
    taken = []
    with one_blas_thread():
        for item in items[:: max(1, len(items) // TIMED)]:
            picture, box = read_picture(item), item.roi
            if box is None:
                continue
            began = time.thread_time()
            classifier.probabilities([cut(picture, box, classifier.margin)])
            taken.append(time.thread_time() - began)
    return round(1e3 * float(np.median(taken)), 3)


def _tell(result: Result) -> str:
    f = result.figures
    rows = [["frames fused", *MODES]]
    for i, frames in enumerate(f["frames"]):
        if frames in SHOWN:
            rows.append([str(frames), *(f"{f['rates'][mode][i]:.4f}" for mode in MODES)])
    worse = [n for i, n in enumerate(f["frames"]) if f["rates"]["scale"][i] < f["rates"]["equal"][i]]
    verdict = (
        "Weighting by scale is nowhere worse than equal weights."
        if not worse
        else f"Weighting by scale is worse than equal weights at {', '.join(map(str, worse))} frames."
    )
    fused = f"Over {f['frames'][-1]} frames {f['rates']['scale'][-1]:.4f} of the signs are right (bar 0.995)."
    single = (
        f"{f['single']:.4f} of the single crops are right (bar 0.98, aim 0.99). Reading one takes one thread "
        f"{f['crop_ms']:.2f} ms (median of CPU time; bar 1 ms)."
    )
    return f"{single} {fused}\n\n{table(rows)}\n{verdict}\n"


def _plot(result: Result, path: Path) -> None:
    f = result.figures
    with drawing(path) as axes:
        for mode, style in zip(MODES, ("-", "--", ":"), strict=True):
            axes.plot(f["frames"], f["rates"][mode], style, label=mode)
        axes.axhline(f["single"], color="#999999", linewidth=1, label="single crops")
        axes.set(xlabel="frames fused, far to near", ylabel="signs classified correctly")
        axes.legend()


EXPERIMENT = Experiment(
    "fusion",
    "Fusing the votes of a sign (Fig. 13)",
    "How much does a sign gain from its earlier views, and does it pay to weight them by size?",
    _run,
    _tell,
    _plot,
)
