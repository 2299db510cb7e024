"""Protocol A: labels that no training has shown are taught from a few tracks, as a retraining teaches them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.gtsrb import CropItem, tracks_of
from tsr_engine.labels.classes import default_keys
from tsr_engine.recognition.classifier import SignClassifier, softmax
from tsr_engine.training.corrections.refine_classifier import (
    ClassifierRefinement,
    SignCrop,
    refine_classifier,
    with_labels,
)
from tsr_engine.training.public.classifier import ClassifierSettings, fit_arrays
from tsr_engine.training.public.classifier_figures import fit_temperature
from tsr_engine.training.public.memory import crop_memory
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, load_crop, plain_view

HIDDEN: Final = (4, 10, 12, 17, 18, 25, 35, 38)
"""Two of each family: red rings, signs of their own face, warnings, blue discs; each with 27 tracks or more."""
TAUGHT_FROM: Final = {1: 3, 5: 3, 20: 1}
"""Tracks of each label -> how often they are chosen; choices of many tracks differ little."""
FRAMES: Final = 12
"""Frames of a taught track, spread over its growth, as a retraining takes them."""


def _silent(stage: str, done: int, total: int) -> None:
    """No progress."""


def base_classifier(
    items: Sequence[CropItem], held: Sequence[CropItem], seed: int, settings: ClassifierSettings | None = None
) -> SignClassifier:
    """The classifier as shipped, but trained without the hidden labels.

    Args:
        items: crops of the tracks that are learned; those of hidden labels are left out here.
        held: crops of other tracks, which the temperature is fitted to, those of hidden labels left out.
        seed: of weights and views.
        settings: unset: as shipped.
    """
    crops = [load_crop(item) for item in items if item.class_id not in HIDDEN]
    arrays = fit_arrays(crops, settings or ClassifierSettings(), seed, _silent, "", HIDDEN)
    base = SignClassifier.from_arrays(arrays, 1.0, paired=True)
    known = [load_crop(item) for item in held if item.class_id not in HIDDEN]
    margins = base.margins([plain_view(crop) for crop in known])
    return replace(base, temperature=fit_temperature(margins, np.array([crop.class_id for crop in known])))


def teach(
    base: SignClassifier, items: Sequence[CropItem], held: Sequence[CropItem], seed: int
) -> dict[str, dict[str, float]]:
    """What is read right before, and after teaching from 1, 5 and 20 tracks a label.

    Args:
        base: from :func:`base_classifier`.
        items: crops to learn from.
        held: crops of other tracks.
        seed: of the draws.

    Returns:
        By number of tracks, see :func:`figures_of`; means over the choices of the taught tracks.
    """
    known = [item for item in items if item.class_id not in HIDDEN]
    moment, _, _ = crop_memory(known, base, np.random.default_rng([seed, 11]), _silent, HIDDEN)
    grown = with_labels(base, [f"taught-{default_keys()[number]}" for number in HIDDEN])
    column = {number: len(base.bias) + place for place, number in enumerate(HIDDEN)}
    tracks = tracks_of(held)
    features = base.read([plain_view(load_crop(item)) for track in tracks.values() for item in track])
    signs = np.repeat(np.arange(len(tracks)), [len(track) for track in tracks.values()])
    truth = np.array([column.get(class_id, class_id) for class_id, _ in tracks])
    old = len(base.bias)
    found = {"0": figures_of(base.margins_of(features), base.temperature, signs, truth, old)}
    for count, draws in TAUGHT_FROM.items():
        each = []
        for draw in range(draws):
            crops = taught_crops(items, count, column, np.random.default_rng([seed, draw, count]))
            weights, bias = refine_classifier(
                grown, crops, moment, len(tracks_of(known)), ClassifierRefinement(), seed, _silent
            )
            each.append(figures_of(features @ weights + bias, base.temperature, signs, truth, old))
        found[str(count)] = {name: float(np.mean([one[name] for one in each])) for name in each[0]}
    return found


def taught_crops(
    items: Sequence[CropItem], count: int, column: Mapping[int, int], rng: np.random.Generator
) -> list[SignCrop]:
    """Crops of so many tracks of each hidden label.

    Args:
        items: crops of tracks.
        count: tracks of each label.
        column: class of GTSRB -> the number that it is taught as.
        rng: draws the tracks.
    """
    crops = []
    tracks = tracks_of(items)
    for number in HIDDEN:
        own = [key for key in tracks if key[0] == number]
        for place in rng.permutation(len(own))[:count]:
            frames = tracks[own[place]]
            for i in np.unique(np.linspace(0, len(frames) - 1, FRAMES).round().astype(int)):
                crop = load_crop(frames[i])
                crops.append(SignCrop(LoadedCrop(crop.pixels, crop.box, column[number]), str(own[place])))
    return crops


def figures_of(
    margins: NDArray[np.float32], temperature: float, signs: NDArray[np.int64], truth: NDArray[np.int64], old: int
) -> dict[str, float]:
    """Shares of single crops and of tracks that are read right, among old labels and new ones.

    The ``mixed`` figures bound the classifier with a network beside it that lacks the new labels
    (:mod:`tsr_engine.recognition.mixture`), whatever this network says. ``mixed_new``: tracks of new labels that have
    more votes than the other new labels, and than all old labels together. ``mixed_old`` and ``mixed_old_half``: tracks
    of old labels in which no new label has more votes than all old labels together, or than half of these votes; they
    are read right if the right label has that much among the old ones.

    Args:
        margins: shape (crops, labels).
        temperature: of the softmax.
        signs: shape (crops,): the track of each.
        truth: shape (tracks,): the right column.
        old: number of the model's own labels; new ones follow.
    """
    answers = softmax(margins, temperature)
    right = answers.argmax(axis=1) == truth[signs]
    votes = np.zeros((len(truth), answers.shape[1]))
    np.add.at(votes, signs, answers)
    read = votes.argmax(axis=1) == truth
    known = truth < old
    rest, new = votes[:, :old].sum(axis=1), votes[:, old:]
    has = truth < votes.shape[1]  # before the teaching there is no column of a new label
    own = np.where(has, votes[np.arange(len(truth)), np.where(has, truth, 0)], 0.0)
    taken = new.max(axis=1, initial=0.0)
    return {
        "old_single": float(right[known[signs]].mean()),
        "new_single": float(right[~known[signs]].mean()),
        "old_tracks": float(read[known].mean()),
        "new_tracks": float(read[~known].mean()),
        "mixed_new": float(((own >= taken) & (own > rest))[~known].mean()),
        "mixed_old": float((taken < rest)[known].mean()),
        "mixed_old_half": float((taken < 0.5 * rest)[known].mean()),
        "worst_label": float(min(read[truth == label].mean() for label in np.unique(truth[~known]))),
    }
