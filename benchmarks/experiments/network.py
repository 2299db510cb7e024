"""What the network reads that models have beside their classifier."""

from __future__ import annotations

import numpy as np

from benchmarks.classifiers.networks import trained_on
from benchmarks.classifiers.stored import FOLDS, crop_time, folds
from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import table
from tsr_engine.evaluation.fusion import evaluate_fusion, track_votes
from tsr_engine.params import Params
from tsr_engine.training.public.classifier import load_all
from tsr_engine.training.public.classifier_figures import held_out_figures

FIGURES = ("accuracy", "accuracy_shaken_boxes", "negative_log_likelihood")


def _run(data: Data) -> Result:
    votes, each = [], []
    crop_ms = 0.0
    for number, (train, held) in enumerate(folds(data)):
        classifier = trained_on(train, held, data, f"network-fold-{number}")
        crop_ms = crop_ms or crop_time(held, classifier)
        _, figures = held_out_figures(classifier, load_all(held, lambda *_: None, ""), data.seed)
        each.append({**figures, "tracks": len({item.track for item in held})})
        votes += track_votes(held, classifier)
    report = evaluate_fusion(votes, Params().fusion)
    crops = np.array([one["crops"] for one in each])
    return Result(
        data=f"GTSRB training set, split by physical sign: each of {FOLDS} parts is held out once and classified by a "
        "network that was trained on the others.",
        figures={
            **{name: float(np.average([one[name] for one in each], weights=crops)) for name in FIGURES},
            "crops": int(crops.sum()),
            "tracks": report.tracks,
            "frames": report.frames[-1],
            "fused": report.rates["clamped"][-1],
            "crop_ms": crop_ms,
            "each": each,
        },
        settings={"seed": data.seed, "folds": FOLDS},
    )


def _report(result: Result) -> str:
    f = result.figures
    rows = [["part held out", "signs", "single crops", "box off", "mean negative log-likelihood"]]
    for name, one in [*((str(number), one) for number, one in enumerate(f["each"])), ("all", f)]:
        rows.append([name, str(one["tracks"]), *(f"{one[figure]:.4f}" for figure in FIGURES)])
    wrong = round(f["tracks"] * (1 - f["fused"]))
    return (
        f"{f['accuracy']:.4f} of the single crops are correct with the annotated boxes, "
        f"{f['accuracy_shaken_boxes']:.4f} with boxes off by up to 11 % shift, 12 % scale and 6 % aspect at once. Over "
        f"{f['frames']} frames {wrong} of the {f['tracks']} signs {'is' if wrong == 1 else 'are'} classified wrongly. "
        f"A crop takes one thread {f['crop_ms']:.2f} ms (median of CPU time; bar 1 ms). *Fusing the votes of a sign* "
        f"has the figures of the classifier, *Reading by classifier and network together* those of the default. "
        "The temperature of each network is fitted to the part that it is measured on, which favours the likelihoods."
        f"\n\n{table(rows)}"
    )


EXPERIMENT = Experiment(
    "network", "Reading by the network", "How accurate is the network alone (`reader=network`)?", _run, _report
)
