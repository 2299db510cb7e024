"""Describes the other systems of the paper's comparison, their training, and its time."""

from __future__ import annotations

from benchmarks.experiment import Data, Experiment, Result, table
from benchmarks.systems.trained import TrainedSystem, split, trained
from tsr_engine.json_shapes import JsonObject

__all__ = ["EXPERIMENT"]

BUDGET = 15
"""Training time of a system on one core, minutes."""


def _run(data: Data) -> Result:
    train, calibrate, report = split(data)
    systems = trained(data)
    return Result(
        "systems",
        data=f"GTSDB, the split by scene of the shipped detector's figures: {len(train)} scenes train, "
        f"{len(calibrate)} calibrate, the {len(report)} others are left for *Detection on unseen scenes*; GTSRB crops "
        "as further signs, as for our own detector.",
        figures={"budget_minutes": BUDGET, "systems": [_plain(system) for system in systems]},
        settings={"seed": data.seed, **{system.system.name: system.sha256[:12] for system in systems}},
    )


def _plain(system: TrainedSystem) -> JsonObject:
    return {"name": system.system.name, "title": system.system.title, **system.record}


def _tell(result: Result) -> str:
    f = result.figures
    rows = [["system", "scenes", "signs", "crops", "samples of signs", "of background", "training, CPU minutes"]]
    for s in f["systems"]:
        counts = (s["scenes"], s["signs"], s["crops"], s["positives"], s["negatives"])
        rows.append([s["title"], *(f"{n:,}" for n in counts), f"{s['cpu_seconds'] / 60:.1f}"])
    recall = next((s["calibration_proposal_recall"] for s in f["systems"] if "calibration_proposal_recall" in s), None)
    over = [s["title"] for s in f["systems"] if s["cpu_seconds"] > 60 * f["budget_minutes"]]
    parts = [table(rows)]
    parts.append(
        f"\nThe budget was {f['budget_minutes']} minutes of one core each, "
        + (f"which {' and '.join(over)} overran. " if over else "and was kept. ")
        + "Our own detector trains for about half an hour (docs/models.md), so part of any difference is effort.\n"
    )
    parts.append(
        "\n*HOG cascade*: grey picture, blocks of nine sizes with nine orientations each quarter, boosted trees of two "
        "levels, early rejection from the calibration scenes; window, scales, search bands, jitter, light and hard "
        "background as for our own, no colour and no refine-and-verify stage. *Colour + MSER + HOG SVM*: after Yang "
        "et al. 2016, "
        "[20] of the paper; Gaussians in the normalised Ohta plane (fitted by expectation maximisation to annotated "
        "boxes, not to hand-picked pixels), OpenCV's MSER on a map for each of red, blue and yellow and on the grey "
        "picture (for signs without colour), a HOG with colour cells, a linear SVM for each of five families of "
        "signs. The wheel of OpenCV 5 has no HOG descriptor any more; both use one of this repository.\n"
    )
    if recall is not None:
        parts.append(
            f"\nMSER proposes {recall:.1%} of the calibration scenes' signs (IoU 0.5): what it does not propose, no "
            "SVM can find.\n"
        )
    return "".join(parts)


EXPERIMENT = Experiment(
    "systems",
    "The systems compared with",
    "Which detectors of the paper's comparison were built here, on which data, with how much effort?",
    _run,
    _tell,
)
