"""Likeness: whether a refined candidate shows one of the 43 signs, or only something of their outline.

Cascade and verifier know signs as one class: a porthole is round and dark, a shop's arrow is white on blue. One machine
a class, trained to refuse what the cascade lets through, tells those apart by what is drawn inside. It looks at a
crop of the refined box, so it runs on a handful of boxes a picture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tsr_engine.recognition.classifier import ARRAYS, SignClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.records import FloatArray, Picture


@dataclass(frozen=True, slots=True)
class Likeness:
    """Machines that answer for one class each and refuse background.

    Attributes:
        machines: margins of the 43 classes.
    """

    machines: SignClassifier

    def scores(self, picture: Picture, boxes: FloatArray) -> FloatArray:
        """The highest margin of any class, shape (n,); boxes (n, 4) beside the picture get -1.

        Args:
            picture: BGR, uint8.
            boxes: refined boxes, px.
        """
        height, width = picture.shape[:2]
        out = np.full(len(boxes), -1.0)
        low, high = np.maximum(boxes[:, :2], 0.0), np.minimum(boxes[:, 2:], [width, height])
        inside = np.flatnonzero((high - low >= 1.0).all(axis=1))
        if len(inside):
            crops = [cut(picture, boxes[i], self.machines.margin) for i in inside]
            out[inside] = self.machines.margins(crops).max(axis=1)
        return out

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Likeness:
        """From a model component's arrays ``likeness_*`` (see :meth:`to_arrays`).

        Raises:
            KeyError: an array is missing.
            ValueError: shapes do not fit together.
        """
        return cls(SignClassifier.from_arrays({name: arrays[f"likeness_{name}"] for name in ARRAYS}, 1.0))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays from which :meth:`from_arrays` makes the same machines; matrices as float16."""
        features = self.machines.features
        return {
            "likeness_filters": features.filters.astype(np.float16),
            "likeness_filter_bias": features.filter_bias,
            "likeness_hidden": features.hidden.astype(np.float16),
            "likeness_hidden_bias": features.hidden_bias,
            "likeness_weights": self.machines.weights.astype(np.float16),
            "likeness_bias": self.machines.bias,
        }
