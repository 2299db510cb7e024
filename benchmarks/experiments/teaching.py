"""Protocol A: what labels cost and give that a model has never seen and corrections teach."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.classifiers.stored import TRAINING_CODE, folds, stored_classifier, training_digest
from benchmarks.classifiers.teaching_labels import FRAMES, HIDDEN, TAUGHT_FROM, base_classifier, teach
from benchmarks.experiment import Data, Experiment, Result
from benchmarks.reporting.markdown import met, table
from tsr_engine.io.gtsrb import CropItem
from tsr_engine.io.models import Component
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.labels.classes import default_keys
from tsr_engine.recognition.classifier import COMPONENT, GEOMETRY, SignClassifier
from tsr_engine.training.public.classifier import ClassifierSettings

BARS = {"5": 0.90, "20": 0.97}
"""Tracks of each new label -> the share of them that is to be read right."""
MAX_LOST_POINTS = 0.2
"""Points of tracks that the other labels may lose."""


def _run(data: Data) -> Result:
    train, held = folds(data)[0]
    keys = default_keys()
    return Result(
        data=f"GTSRB training set, split by physical sign: {len({item.track for item in held})} signs are reported on. "
        "The base classifier was trained on the others like the shipped classifier, but without any sign, drawing or "
        "mirror image of "
        f"{len(HIDDEN)} labels: {', '.join(keys[number].replace('-', ' ') for number in HIDDEN)}.",
        figures=teach(_base(train, held, data), train, held, data.seed),
        settings={"seed": data.seed, "choices": {str(count): draws for count, draws in TAUGHT_FROM.items()}},
    )


def _base(items: Sequence[CropItem], held: Sequence[CropItem], data: Data) -> SignClassifier:
    """The classifier without the hidden labels, trained once for a scratch folder."""
    settings = ClassifierSettings()

    def component() -> Component:
        base = base_classifier(items, held, data.seed, settings)
        arrays = {**base.features.to_arrays(), "weights": base.weights, "bias": base.bias}
        params = {**GEOMETRY, "temperature": base.temperature, "paired": base.paired}
        return Component(COMPONENT, arrays, params, {}, {}, data.seed)

    digest = training_digest(TRAINING_CODE, settings, HIDDEN)
    return stored_classifier(data.scratch / f"classifier-without-labels-{data.seed}-{digest}", COMPONENT, component)


def _report(result: Result) -> str:
    rows = [
        ["tracks of each new label", "new labels, tracks", "worst of them", "new, single crops", "other labels, tracks",
         "other, single crops", "new, tracks, with a network", "other, tracks, with a sure network",
         "other, tracks, with a network half sure"],
    ]  # fmt: skip
    names = (
        "new_tracks", "worst_label", "new_single", "old_tracks", "old_single", "mixed_new", "mixed_old",
        "mixed_old_half",
    )  # fmt: skip
    for count in sorted(result.figures, key=int):
        rows.append([count, *(f"{result.figures[count][name]:.4f}" for name in names)])
    return f"{table(rows)}\n{_verdict(result.figures)}\n"


def _verdict(f: JsonMapping) -> str:
    lines = []
    for count, bar in BARS.items():
        taught, base = f[count], f["0"]
        new, mixed, old = taught["new_tracks"], taught["mixed_new"], taught["mixed_old_half"]
        tracks, single = (100 * max(0.0, base[name] - taught[name]) for name in ("old_tracks", "old_single"))
        lines.append(
            f"- {count} tracks of each new label: {new:.3f} of the new labels' tracks are classified correctly (bar "
            f"{bar:.2f}: {met(new >= bar)}). The other labels lose {tracks:.2f} percentage points of "
            f"tracks (bar {MAX_LOST_POINTS}: {met(tracks <= MAX_LOST_POINTS)}) and {single:.2f} of "
            "single crops. Beside a network that lacks the new labels, whatever it answers, at least "
            f"{mixed:.3f} of the new labels' tracks are correct (bar {bar:.2f}: "
            f"{met(mixed >= bar)}). {100 * (1 - old):.2f} % of the other labels' tracks can change "
            "to a new label if classifier and network together give the right label at least half of the old labels' "
            "votes.\n"
        )
    return (
        f"{''.join(lines)}\nLabels are taught as in a retraining, {FRAMES} frames a track. A track is classified by "
        "the sum of its frames' probabilities. Figures are means over "
        f"{', '.join(map(str, TAUGHT_FROM.values()))} random choices of {', '.join(map(str, TAUGHT_FROM))} tracks."
    )


EXPERIMENT = Experiment(
    "teaching",
    "Teaching new labels",
    "How many tracks of a new label does a retraining need, and how much do the other labels lose?",
    _run,
    _report,
)
