"""Refines the classifier with corrected crops, by the smallest change of its hyperplanes.

The feature map stays. The hyperplanes are fitted to views of the corrected crops with the squared hinge loss of their
training, and a penalty on changes for the earlier data: a change ``D`` costs the mean square of the margins that it
moves on the earlier crops, ``tr(D^T M D)`` with ``M`` their second moment, times the number of tracks that these were.
The penalty is high for appearances that are frequent in the earlier data, and low for those that it lacks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from tsr_engine.io.pictures import read_picture
from tsr_engine.labels.classes import default_keys
from tsr_engine.recognition.classifier import SignClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.records import FloatArray
from tsr_engine.training.corrections.corrected_scenes import CorrectedScene
from tsr_engine.training.progress import Progress
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, jittered_view, plain_view

__all__ = ["ClassifierRefinement", "SignCrop", "refine_classifier", "sign_crops", "with_labels"]


_ROOM = 0.6
"""Pixels kept around a crop, as a share of its side: views are shifted and rotated."""


@dataclass(frozen=True, slots=True)
class ClassifierRefinement:
    """The settings of a refinement of the classifier.

    Attributes:
        views: views per crop; the first is unchanged.
        weight: weight of one corrected sign relative to one track of the earlier data.
        strength: of the views' distortions, 0 to 1.
    """

    views: int = 12
    weight: float = 8.0
    strength: float = 0.6


@dataclass(frozen=True, slots=True)
class SignCrop:
    """A crop of a corrected sign, and which sign it is."""

    crop: LoadedCrop
    sign: str


def sign_crops(scenes: Sequence[CorrectedScene], progress: Progress) -> list[SignCrop]:
    """Crops of all signs of corrected frames, with surroundings."""
    out = []
    for done, scene in enumerate(scenes):
        progress("crops of corrected signs", done, len(scenes))
        if not scene.signs:
            continue
        picture = read_picture(scene.scene.path)
        for box, label, sign in zip(scene.scene.boxes, scene.scene.class_ids, scene.signs, strict=True):
            pixels = cut(picture, box, _ROOM)
            width, height = box[2] - box[0], box[3] - box[1]
            left, top = _ROOM * width, _ROOM * height
            inner = np.array([left, top, left + width, top + height])
            out.append(SignCrop(LoadedCrop(pixels, inner, int(label)), sign))
    return out


def with_labels(classifier: SignClassifier, keys: Sequence[str]) -> SignClassifier:
    """Add a machine for each further label to a classifier; the new machines reject everything so far.

    Args:
        classifier: the earlier classifier.
        keys: labels that it lacks; their numbers follow its own.
    """
    if not keys:
        return classifier
    length, count = classifier.weights.shape[0], len(keys)
    return replace(
        classifier,
        weights=np.concatenate([classifier.weights, np.zeros((length, count), np.float32)], axis=1),
        bias=np.concatenate([classifier.bias, np.full(count, -1, np.float32)]),
        labels=(*(classifier.labels or default_keys()), *keys),
    )


def refine_classifier(
    classifier: SignClassifier,
    crops: Sequence[SignCrop],
    moment: FloatArray,
    tracks: int,
    settings: ClassifierRefinement,
    seed: int,
    progress: Progress,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """New hyperplanes.

    scikit-learn's ``LinearSVC`` pulls hyperplanes towards zero; this pulls them towards the earlier ones, weighted by
    the moment of their data.

    Args:
        classifier: the earlier one.
        crops: of corrected signs.
        moment: mean of ``x x^T`` over the earlier data, ``x`` = features and 1, shape (h + 1, h + 1).
        tracks: number of tracks that the moment stands for.
        settings: how strongly.
        seed: of the views.
        progress: called with stage, number done, number in all.

    Returns:
        Weights (h, c) and bias (c,); half precision, as they are stored.

    Raises:
        ValueError: no crops.
    """
    if not crops:
        raise ValueError("The classifier is refined with corrected signs of known class. Got none.")
    features, labels, weights = _views(classifier, crops, settings, seed, progress)
    rows = np.concatenate([features, np.ones((len(features), 1))], axis=1)
    target = np.full((len(rows), len(classifier.bias)), -1.0)
    target[np.arange(len(rows)), labels] = 1.0
    start = np.concatenate([classifier.weights, classifier.bias[None]]).astype(np.float64)
    margins = rows @ start
    hold = tracks * (moment + 1e-4 * np.trace(moment) / len(moment) * np.eye(len(moment)))
    share = (settings.weight * weights)[:, None]

    def cost(flat: FloatArray) -> tuple[float, FloatArray]:
        change = flat.reshape(start.shape)
        slack = np.maximum(0.0, 1.0 - target * (margins + rows @ change))
        held = hold @ change
        value = float((share * slack**2).sum() + (change * held).sum())
        return value, (2 * (held - rows.T @ (share * target * slack))).ravel()

    progress("hyperplanes", 0, 1)
    found = minimize(cost, np.zeros(start.size), jac=True, method="L-BFGS-B", options={"maxiter": 300})
    refined = start + found.x.reshape(start.shape)
    return refined[:-1].astype(np.float16).astype(np.float32), refined[-1].astype(np.float32)


def _views(
    classifier: SignClassifier,
    crops: Sequence[SignCrop],
    settings: ClassifierRefinement,
    seed: int,
    progress: Progress,
) -> tuple[FloatArray, NDArray[np.int64], FloatArray]:
    """Features, classes and weights of views; each sign weighs 1 in all."""
    rng = np.random.default_rng([seed, 31])
    count: dict[str, int] = {}
    for item in crops:
        count[item.sign] = count.get(item.sign, 0) + 1
    features: list[NDArray[np.generic]] = []
    labels, weights = [], []
    for done, item in enumerate(crops):
        progress("views of crops", done, len(crops))
        views = [(plain_view(item.crop), item.crop.class_id)]
        views += [jittered_view(item.crop, rng, settings.strength) for _ in range(settings.views - 1)]
        features.append(classifier.features.of_patches(np.stack([view for view, _ in views])))
        labels += [label for _, label in views]
        weights += [1.0 / (count[item.sign] * len(views))] * len(views)
    return np.concatenate(features).astype(np.float64), np.array(labels), np.array(weights)
