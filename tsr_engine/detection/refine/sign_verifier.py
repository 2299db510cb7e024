"""The sign verifier: decides whether a refined candidate shows one of the 43 signs or only a similar shape.

Cascade and verifier treat signs as one class and accept a round dark porthole or a shop's white arrow on blue. The sign
verifier has one machine for each class, trained to reject background that passes the cascade by the drawing inside. A
sign whose class is hard to tell has a low margin for each of them; a common machine for all classes on the same
features still accepts it. All read a crop of the refined box, so they run on a handful of boxes in a picture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.recognition.classifier import ARRAYS, SignClassifier
from tsr_engine.recognition.crops import cut
from tsr_engine.recognition.features import linear
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray, Picture


@dataclass(frozen=True, slots=True)
class SignVerifier:
    """Machines for one class each, or for all, that reject background.

    Attributes:
        machines: margins of the 43 classes.
        common: hyperplane of the machine for all classes, shape (h + 1,), the bias last; None: an older model without
            this machine.
    """

    machines: SignClassifier
    common: NDArray[np.float32] | None = None

    def scores(self, picture: Picture, boxes: FloatArray) -> FloatArray:
        """Mean of the highest class margin and the common margin, shape (n,); -1 for boxes outside the picture.

        Args:
            picture: BGR, uint8.
            boxes: refined boxes, shape (n, 4), px.
        """
        height, width = picture.shape[:2]
        out = np.full(len(boxes), -1.0)
        low, high = np.maximum(boxes[:, :2], 0.0), np.minimum(boxes[:, 2:], [width, height])
        inside = np.flatnonzero((high - low >= 1.0).all(axis=1))
        if len(inside):
            crops = [cut(picture, boxes[i], self.machines.margin) for i in inside]
            features = self.machines.read(crops)
            out[inside] = self.machines.margins_of(features).max(axis=1)
            if self.common is not None:
                common = linear(features, self.common[:-1, None], self.common[-1:])[:, 0]
                out[inside] = (out[inside] + common) / 2
        return out

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]]) -> SignVerifier:
        """Make it from a model component's arrays ``likeness_*`` (see :meth:`to_arrays`).

        Raises:
            KeyError: an array is missing.
            ValueError: shapes do not fit together.
        """
        own = {name: arrays[f"likeness_{name}"] for name in ARRAYS}
        weights, bias = own["weights"], own["bias"]
        common = None
        if weights.shape[1] == CLASS_COUNT + 1:
            common = np.append(weights[:, CLASS_COUNT], bias[CLASS_COUNT]).astype(np.float32)
            own |= {"weights": weights[:, :CLASS_COUNT], "bias": bias[:CLASS_COUNT]}
        return cls(SignClassifier.from_arrays(own, 1.0, paired=common is not None), common)

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Arrays from which :meth:`from_arrays` makes the same machines; matrices as float16."""
        weights, bias = self.machines.weights, self.machines.bias
        if self.common is not None:
            weights = np.column_stack([weights, self.common[:-1]])
            bias = np.append(bias, self.common[-1])
        return {
            **self.machines.features.to_arrays("likeness_"),
            "likeness_weights": weights.astype(np.float16),
            "likeness_bias": bias,
        }
