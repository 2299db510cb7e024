"""A reader of sign crops from two classifiers: one that corrections have taught, and the network beside it.

A label that the network lacks has the classifier's probability. The rest goes to the labels that both know, by the
geometric mean of their probabilities (a log-opinion pool, Genest and Zidek 1986). Both weigh the same. The weight is
not tuned.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tsr_engine.recognition.classifier import SignClassifier, normalise_logarithms
from tsr_engine.records import FloatArray, Picture

if TYPE_CHECKING:
    from tsr_engine.protocols import CropClassifier


@dataclass(frozen=True, slots=True)
class Mixture:
    """Class probabilities of sign crops by two classifiers. Implements ``CropClassifier``."""

    classifier: SignClassifier
    """The one whose classes the answers have."""
    network: SignClassifier
    known: tuple[int, ...]
    """For each class of the classifier the network's class of the same sign; -1: the network lacks it."""

    def __post_init__(self) -> None:
        """Refuse what does not fit together.

        Raises:
            ValueError: crops of two margins, or classes of the network that are none or stand twice.
        """
        if self.classifier.margin != self.network.margin:
            raise ValueError(
                f"Mixture needs two classifiers of one margin. Got {self.classifier.margin} and {self.network.margin}."
            )
        shared = [index for index in self.known if index >= 0]
        wrong = len(set(shared)) < len(shared) or max(shared, default=0) >= len(self.network.bias)
        if wrong or len(self.known) != len(self.classifier.bias):
            raise ValueError(
                f"Mixture needs a class of the network, or -1, for each of {len(self.classifier.bias)} classes. "
                f"Got {self.known}."
            )

    @property
    def margin(self) -> float:
        """Border on each side of the box that a crop must carry, as a share of the box's side."""
        return self.classifier.margin

    @property
    def labels(self) -> tuple[str, ...]:
        """Key of the label that each class is; empty: the 43 classes of the catalogue."""
        return self.classifier.labels

    def probabilities(self, crops: list[Picture]) -> NDArray[np.float32]:
        """``P(c | x)``, shape (n, c), rows sum to 1; a row does not depend on the rest of the batch.

        Args:
            crops: BGR, uint8, any sizes: a sign's box and its ``margin``.
        """
        return pool_probabilities(*self.logarithms(crops), self.known).astype(np.float32)

    def logarithms(self, crops: list[Picture]) -> tuple[FloatArray, FloatArray]:
        """Logarithms of both classifiers' probabilities, each row up to a constant, shapes (n, c) and (n, d)."""
        classifier_logs, network_logs = (
            each.margins(crops).astype(np.float64) / each.temperature for each in (self.classifier, self.network)
        )
        return classifier_logs, network_logs


def pool_probabilities(classifier_logs: FloatArray, network_logs: FloatArray, known: tuple[int, ...]) -> FloatArray:
    """Probabilities of both classifiers as one, shape (n, c).

    Args:
        classifier_logs: logarithms of the classifier's probabilities, each row up to a constant, shape (n, c).
        network_logs: those of the network, shape (n, d).
        known: the network's class for each class of the classifier; -1: none.
    """
    shared = np.flatnonzero(np.array(known) >= 0)
    out = normalise_logarithms(classifier_logs)
    # np.take gives rows that lie one after the other, so their sums do not depend on the number of rows.
    mass = np.take(out, shared, axis=1).sum(axis=1, keepdims=True)
    combined = np.take(classifier_logs, shared, axis=1) + np.take(network_logs, np.array(known)[shared], axis=1)
    out[:, shared] = mass * normalise_logarithms(0.5 * combined)
    return out


if TYPE_CHECKING:

    def _is_crop_classifier(mixture: Mixture) -> CropClassifier:
        return mixture
