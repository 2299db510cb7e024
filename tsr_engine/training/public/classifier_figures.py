"""Computes temperature, accuracy and likelihood of a classifier on crops that its weights have not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from tsr_engine.recognition.classifier import SignClassifier, softmax
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop, box_view, plain_view, shaken_box

__all__ = ["fit_temperature", "held_out_figures", "negative_log_likelihood"]


def held_out_figures(
    classifier: SignClassifier, held: Sequence[LoadedCrop], seed: int
) -> tuple[float, dict[str, float]]:
    """Temperature and single-crop figures on pictures that the weights have not seen.

    Returns:
        The temperature, and the figures: accuracy on the annotated boxes, and on boxes with detector-like errors
        (shifts up to 11 %, scales up to 12 %, aspects up to 6 %), mean negative log-likelihood at the temperature, and
        number of crops.
    """
    generator = np.random.default_rng([seed, 2])
    labels = np.array([crop.class_id for crop in held])
    margins = classifier.margins([plain_view(crop) for crop in held])
    shaken = classifier.margins([box_view(crop, shaken_box(crop.box, generator)) for crop in held])
    temperature = fit_temperature(margins, labels)
    return temperature, {
        "accuracy": float((margins.argmax(1) == labels).mean()),
        "accuracy_shaken_boxes": float((shaken.argmax(1) == labels).mean()),
        "negative_log_likelihood": negative_log_likelihood(margins, labels, temperature),
        "crops": len(held),
    }


def fit_temperature(margins: NDArray[np.floating], labels: NDArray[np.int64]) -> float:
    """The temperature in [0.01, 100] that maximises the likelihood of the labels under the softmax.

    scikit-learn fits temperatures only within a classifier that it calibrates (``CalibratedClassifierCV``), and does
    not expose them.

    Args:
        margins: shape (n, c), of pictures that the weights have not seen.
        labels: shape (n,).
    """
    best = minimize_scalar(
        lambda log_t: negative_log_likelihood(margins, labels, float(np.exp(log_t))),
        bounds=(np.log(0.01), np.log(100.0)),
        method="bounded",
        options={"xatol": 1e-4},
    )
    return float(np.exp(best.x))


def negative_log_likelihood(margins: NDArray[np.floating], labels: NDArray[np.int64], temperature: float) -> float:
    """Mean of ``-log P(label)``, probabilities floored at 1e-12."""
    p = softmax(margins, temperature)[np.arange(len(labels)), labels].astype(np.float64)
    return float(-np.log(np.maximum(p, 1e-12)).mean())
