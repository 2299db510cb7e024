"""Fig. 13: classification over the number of fused frames."""

from __future__ import annotations

from pathlib import Path

from benchmarks.drawing import drawing
from benchmarks.experiment import Data, Experiment, Result, machine, table
from tsr_engine.evaluation.fusion import MODES, evaluate_fusion, track_votes
from tsr_engine.io.gtsrb import read_items, split_by_track
from tsr_engine.io.models import load_component, save_component
from tsr_engine.params import Params
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.training.classifier import ClassifierSettings, train_classifier

__all__ = ["EXPERIMENT"]

SHOWN = (1, 2, 3, 5, 8, 12, 16, 20, 25, 30)


def _run(data: Data) -> Result:
    folder = data.need("gtsrb")
    settings = ClassifierSettings(refit_steps=0)  # weights that have never seen the held-out tracks
    kept = data.scratch / f"classifier-split-{data.seed}"
    if not (kept / "manifest.json").is_file():
        save_component(train_classifier(folder, data.seed, settings), kept)
    component = load_component("classifier", kept)
    items = [item for item in read_items(folder) if item.track is not None]
    held = split_by_track(items, settings.held_out, data.seed)[1]
    report = evaluate_fusion(track_votes(held, SignClassifier.from_component(component)), Params().fusion)
    return Result(
        "fusion",
        data=f"GTSRB training set, split by physical sign: {report.tracks} signs held out; the weights have seen only "
        "the others (the shipped ones went on to train on all).",
        figures=report.as_dict(),
        settings={"seed": data.seed, "held_out": settings.held_out},
        machine=machine(),
    )


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
    return f"{f['single']:.4f} of the single crops are right.\n\n{table(rows)}\n{verdict}\n"


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
