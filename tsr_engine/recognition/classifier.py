"""The sign classifier: features, one-vs-rest support vector machine, calibrated softmax.

The features come from a descriptor with its feature map, or from a network.

The paper maps the scores of a multi-class SVM to probabilities by softmax (III-E). On raw margins the softmax
saturates, and confident errors then dominate a track's votes. A temperature, fitted on tracks outside the training set,
calibrates the probabilities.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tsr_engine.errors import ModelError
from tsr_engine.recognition.descriptor import CELL, CHANNELS, MARGIN, SIDE, resize_crops
from tsr_engine.recognition.features import FeatureMap, linear
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.recognition.network import NETWORK_GEOMETRY, NetworkMap
from tsr_engine.recognition.shifted_views import diagonal_pairs
from tsr_engine.records import FloatArray, Picture

if TYPE_CHECKING:
    from tsr_engine.protocols import CropClassifier, TrainedPart

COMPONENT = "classifier"
NETWORK_COMPONENT = "network_classifier"
"""The classifier on the features of a network, which models may have beside the other and which reads with it."""
ARRAYS = ("filters", "filter_bias", "hidden", "hidden_bias", "weights", "bias")
"""Names under which models store the feature map and the hyperplanes."""
GEOMETRY = {"side": SIDE, "cell": CELL, "channels": CHANNELS, "margin": MARGIN}
"""Settings of the descriptor that the weights depend on; stored and checked. For networks: ``NETWORK_GEOMETRY``."""

Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SignClassifier:
    """Class margins and probabilities of sign crops. Implements ``CropClassifier``.

    Raises:
        ValueError: shapes do not fit together, labels repeat, or the temperature is not positive.
    """

    features: FeatureMap | NetworkMap
    weights: Array
    """Shape (h, c): one hyperplane for each class."""
    bias: Array
    """Shape (c,)."""
    temperature: float
    """Margins are divided by it before the softmax, > 0."""
    margin: float = MARGIN
    """Border that a crop must have on each side of the box, as a share of the box's side."""
    paired: bool = False
    """Whether the hyperplanes get the mean of the features of two views of a crop (:mod:`~.shifted_views`)."""
    labels: tuple[str, ...] = ()
    """Label key of each class; empty: the 43 classes of the catalogue."""

    def __post_init__(self) -> None:
        count = len(self.labels) or CLASS_COUNT
        if count < 2 or len({key.casefold() for key in self.labels}) != len(self.labels):
            raise ValueError("SignClassifier needs two labels or more, each with a key of its own.")
        shape = (self.features.length, count)
        if self.weights.shape != shape or self.bias.shape != (count,):
            raise ValueError(
                f"SignClassifier needs weights {shape} and bias ({count},). "
                f"Got {self.weights.shape} and {self.bias.shape} instead."
            )
        if not (np.isfinite(self.temperature) and self.temperature > 0):
            raise ValueError(f"The temperature must be finite and > 0. Got {self.temperature} instead.")

    def margins(self, crops: Sequence[Picture]) -> Array:
        """Decision values of the hyperplanes, shape (n, c); > 0 speaks for the class.

        Args:
            crops: BGR, uint8, any sizes: a sign's box and its ``margin``.

        Raises:
            ValueError: a crop that is not a BGR picture.
        """
        return self.margins_of(self.read(crops))

    def margins_of(self, features: Array) -> Array:
        """Decision values of the hyperplanes, shape (n, c), for features (n, h)."""
        return linear(features, self.weights, self.bias)

    def read(self, crops: Sequence[Picture]) -> Array:
        """Features of crops as for ``margins``, shape (n, h).

        Raises:
            ValueError: a crop that is not a BGR picture.
        """
        patches = resize_crops(crops)
        if not self.paired:
            return self.features.of_patches(patches)
        both = self.features.of_patches(diagonal_pairs(patches), together=2)
        mean: Array = both[0::2] + both[1::2]
        mean *= np.float32(0.5)
        return mean

    def probabilities(self, crops: list[Picture]) -> Array:
        """``P(c | x)`` of crops as for ``margins``, shape (n, c), rows sum to 1 and do not depend on each other."""
        return softmax(self.margins(crops), self.temperature)

    @classmethod
    def from_arrays(
        cls,
        arrays: Mapping[str, NDArray[np.generic]],
        temperature: float,
        *,
        paired: bool = False,
        labels: Sequence[str] = (),
    ) -> SignClassifier:
        """Make a classifier from arrays of any float type, named as in ``to_arrays`` of the features and as here.

        Raises:
            KeyError: an array is missing.
            ValueError: shapes do not fit together, or the temperature is not positive.
        """
        weights, bias = (np.ascontiguousarray(arrays[name], dtype=np.float32) for name in ("weights", "bias"))
        features = NetworkMap.from_arrays(arrays) if "kernel0" in arrays else FeatureMap.from_arrays(arrays)
        return cls(features, weights, bias, temperature, paired=paired, labels=tuple(labels))

    @classmethod
    def from_component(cls, component: TrainedPart) -> SignClassifier:
        """Make the classifier of a model component (``arrays`` and ``params``).

        The parameter ``labels`` lists the keys of the classes; without it, they are the 43 of the catalogue.

        Raises:
            ModelError: an array is missing or has a wrong shape, or the weights are for another descriptor.
        """
        arrays, params = component.arrays, component.params
        wanted, kind = (NETWORK_GEOMETRY, "network") if "kernel0" in arrays else (GEOMETRY, COMPONENT)
        found = {key: params.get(key) for key in wanted}
        if found != wanted:
            raise ModelError(
                f"The classifier was trained for another descriptor: expected {wanted}, got {found}. "
                f"Train it again with `tsr train {kind}`."
            )
        try:
            labels = params.get("labels", [])
            if not isinstance(labels, list) or not all(isinstance(key, str) and key.strip() for key in labels):
                raise ValueError("labels must be a list of keys")
            paired = bool(params.get("paired", False))
            return cls.from_arrays(arrays, float(params["temperature"]), paired=paired, labels=labels)
        except (KeyError, ValueError, IndexError, TypeError) as error:
            raise ModelError(
                f"The classifier component is damaged: {error}. Train it again with `tsr train {kind}`."
            ) from None


def softmax(margins: NDArray[np.generic], temperature: float = 1.0) -> Array:
    """Row-wise ``exp(m / T) / sum exp(m / T)``, shape (n, c), computed in float64 without overflow.

    Args:
        margins: shape (n, c).
        temperature: > 0; above 1 flattens.
    """
    return normalise_logarithms(np.asarray(margins, dtype=np.float64) / temperature).astype(np.float32)


def normalise_logarithms(logarithms: FloatArray) -> FloatArray:
    """Row-wise ``exp(l) / sum exp(l)`` without overflow, shape (n, c), for logarithms of that shape."""
    shares: FloatArray = logarithms - logarithms.max(axis=1, keepdims=True, initial=-np.inf)
    np.exp(shares, out=shares)
    shares /= shares.sum(axis=1, keepdims=True)
    return shares


if TYPE_CHECKING:

    def _is_crop_classifier(classifier: SignClassifier) -> CropClassifier:
        return classifier
