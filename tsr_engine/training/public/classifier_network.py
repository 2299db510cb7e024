"""Trains a feature map and its outputs by gradient descent in plain NumPy.

The loss is the squared hinge of the one-vs-rest support vector machine (Tang 2013), cross-entropy, or, for the four
numbers that move a box, Huber's. The optimiser is Adam with decoupled weight decay (Loshchilov & Hutter 2019) and a
cosine schedule. The result is the average of the weights over the last steps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tsr_engine.recognition.features import POSITIONS, WINDOW_LENGTH, windows
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT

Array = NDArray[np.float32]
Wanted = NDArray[Any]  # Any: whole classes, or the real targets of Huber's loss
Loss = Literal["hinge", "cross_entropy", "huber"]
_DECAYED = ("filters", "hidden", "weights")
_BOX_NUMBERS = 4
_ROUND_BELOW = 0.03
"""Box errors below this, in sides, have a quadratic loss, larger ones a linear loss (Huber 1964)."""


@dataclass(frozen=True, slots=True)
class NetworkSettings:
    """Size and regularisation."""

    filters: int = 192
    hidden: int = 384
    drop_hidden: float = 0.4
    """Share of features dropped in a training step."""
    rate: float = 1.5e-3
    """Peak step size of Adam."""
    decay: float = 0.1
    """Decoupled weight decay, in units of the step size."""
    warm_up: int = 200
    """Steps until the peak step size."""
    loss: Loss = "hinge"
    common: bool = False
    """Whether to add a machine for all classes together; only for the hinge."""

    def __post_init__(self) -> None:
        if self.common and self.loss != "hinge":
            raise ValueError(f"A common machine needs the loss 'hinge'. Got {self.loss!r} instead.")

    @property
    def outputs(self) -> int:
        """Number of machines, or of a box's numbers."""
        return _BOX_NUMBERS if self.loss == "huber" else CLASS_COUNT + self.common


class Network:
    """Trainable weights, the moments of their gradients, and their running average."""

    def __init__(self, settings: NetworkSettings, seed: int) -> None:
        self.settings = settings
        self._generator = np.random.default_rng(seed)
        f, h = settings.filters, settings.hidden
        boxes = settings.loss == "huber"  # large answers at first would silence the hidden layer permanently
        self.weights: dict[str, Array] = {
            "filters": self._draw(WINDOW_LENGTH, f, 1.0),
            "filter_bias": np.zeros(f, dtype=np.float32),
            "hidden": self._draw(POSITIONS * f, h, 1.0),
            "hidden_bias": np.zeros(h, dtype=np.float32),
            "weights": self._draw(h, settings.outputs, 0.0 if boxes else 0.3),
            "bias": np.full(settings.outputs, 0.0 if boxes else -0.5, dtype=np.float32),
        }
        self.average = {key: value.copy() for key, value in self.weights.items()}
        self._first = {key: np.zeros_like(value) for key, value in self.weights.items()}
        self._second = {key: np.zeros_like(value) for key, value in self.weights.items()}
        self._step = 0

    def _draw(self, rows: int, columns: int, gain: float) -> Array:
        """Draw normal weights that keep the variance through ``max(0, .)`` (He et al. 2015)."""
        draw = self._generator.standard_normal((rows, columns), dtype=np.float32)
        return np.asarray(draw * np.float32(gain * math.sqrt(2 / rows)), dtype=np.float32)

    def resume(self, arrays: Mapping[str, NDArray[np.generic]]) -> None:
        """Start from given weights."""
        for key, weight in self.weights.items():
            weight[:] = arrays[key]
            self.average[key][:] = arrays[key]

    def train_step(self, descriptors: Array, labels: Wanted, progress: float) -> float:
        """Take one step on one batch.

        Args:
            descriptors: shape (n, 4320).
            labels: shape (n,), classes; negative: no class, only for the hinge. For Huber's loss the targets, shape
                (n, 4).
            progress: completed share of the whole training, in [0, 1): sets the step size.

        Returns:
            Mean loss of the batch.
        """
        w, n = self.weights, len(labels)
        rows = windows(descriptors)
        found: Array = rows @ w["filters"]
        found += w["filter_bias"]
        np.maximum(found, 0, out=found)
        found = found.reshape(n, -1)
        features: Array = found @ w["hidden"]
        features += w["hidden_bias"]
        np.maximum(features, 0, out=features)
        features *= self._mask(features.shape, self.settings.drop_hidden)
        margins: Array = features @ w["weights"]
        margins += w["bias"]
        loss, slope = _LOSSES[self.settings.loss](margins, labels)

        # A unit that max(0, .) or the mask has silenced is exactly 0, so its sign gives the back-propagation mask.
        # The mask's factor 1 / (1 - p) belongs to the slope too.
        back: Array = slope @ w["weights"].T
        back *= (features > 0) * np.float32(1 / (1 - self.settings.drop_hidden))
        lower: Array = back @ w["hidden"].T
        lower *= found > 0
        lower = lower.reshape(len(rows), -1)
        self._adam(
            {
                "weights": features.T @ slope,
                "bias": slope.sum(0),
                "hidden": found.T @ back,
                "hidden_bias": back.sum(0),
                "filters": rows.T @ lower,
                "filter_bias": lower.sum(0),
            },
            progress,
        )
        return loss

    def _mask(self, shape: tuple[int, ...], drop: float) -> Array:
        kept = self._generator.random(shape, dtype=np.float32) >= drop
        return kept * np.float32(1 / (1 - drop))

    def _adam(self, gradients: dict[str, Array], progress: float) -> None:
        self._step += 1
        t = self._step
        rate = self.settings.rate * min(1.0, t / self.settings.warm_up) * 0.5 * (1 + math.cos(math.pi * progress))
        unbias_first, unbias_second = np.float32(1 / (1 - 0.9**t)), np.float32(1 / (1 - 0.999**t))
        for key, gradient in gradients.items():
            first, second, weight = self._first[key], self._second[key], self.weights[key]
            first *= np.float32(0.9)
            first += np.float32(0.1) * gradient
            second *= np.float32(0.999)
            np.square(gradient, out=gradient)
            gradient *= np.float32(0.001)
            second += gradient
            move = first * unbias_first
            move /= np.sqrt(second * unbias_second) + np.float32(1e-8)
            if key in _DECAYED:
                move += np.float32(self.settings.decay) * weight
            move *= np.float32(rate)
            weight -= move
        if t % 4 == 0:
            share = np.float32(1 - min(0.99, (1 + t / 4) / (10 + t / 4)))
            for key, average in self.average.items():
                average += share * (self.weights[key] - average)


def _hinge(margins: Array, labels: NDArray[np.int64]) -> tuple[float, Array]:
    """Squared hinge of 43 machines, summed over machines and averaged over the batch, with its slope.

    A negative label means no class: every machine should reject it. A 44th machine is for all classes together.
    """
    n = len(labels)
    target = np.full(margins.shape, -1, dtype=np.float32)
    known = np.flatnonzero(labels >= 0)
    target[known, labels[known]] = 1
    target[known, CLASS_COUNT:] = 1
    slack = np.maximum(0, 1 - target * margins)
    return float((slack * slack).sum() / n), (np.float32(-2 / n) * target * slack).astype(np.float32)


def _cross_entropy(margins: Array, labels: NDArray[np.int64]) -> tuple[float, Array]:
    """Mean negative log-likelihood of the softmax, with its slope."""
    n = len(labels)
    shifted = margins - margins.max(axis=1, keepdims=True)
    log_sum = np.log(np.exp(shifted).sum(axis=1, keepdims=True))
    log_probability = shifted - log_sum
    slope = np.exp(log_probability)
    slope[np.arange(n), labels] -= 1
    return float(-log_probability[np.arange(n), labels].mean()), (slope / np.float32(n)).astype(np.float32)


def _huber(answers: Array, wanted: Wanted) -> tuple[float, Array]:
    """Huber's loss, summed over the numbers, averaged over the batch, in units of ``_ROUND_BELOW``, with its slope."""
    errors = (answers - wanted.astype(np.float32)) / np.float32(_ROUND_BELOW)
    slope = np.clip(errors, -1, 1)
    return float((slope * (errors - slope / 2)).sum() / len(answers)), slope / np.float32(len(answers))


_LOSSES = {"hinge": _hinge, "cross_entropy": _cross_entropy, "huber": _huber}
