"""Box refinement: a learned regression that moves a box onto the edges of its sign.

The regressions of the refine-and-verify stage are linear and trained on the few hundred signs of the training scenes.
This one is a map of filters and hidden units on the classifier's descriptor, trained also on GTSRB's tens of thousands
of boxes. It runs only on likely signs, a handful of boxes in a picture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.detection.patch import cut_patch
from tsr_engine.geometry import box_steps
from tsr_engine.recognition.descriptor import MARGIN, SIDE, describe_patches
from tsr_engine.recognition.features import FeatureMap, linear
from tsr_engine.records import FloatArray, Picture

__all__ = ["BoxRefinement", "cut_box", "move_edges", "steps_between"]

_BOX_SIDE_PX: Final = SIDE / (1 + 2 * MARGIN)
"""Side of the box in its patch, px. The border equals that of a classifier's crop, because GTSRB shows no more."""
_MAX_STEP: Final = 0.3
"""Largest step, in widths and heights."""


@dataclass(frozen=True, slots=True)
class BoxRefinement:
    """A learned regression from a box's patch to the sign's edges.

    Attributes:
        features: the feature map.
        weights: shape (h, 4), float32: from features to the steps of :func:`move_edges`.
        bias: shape (4,), float32.

    Raises:
        ValueError: shapes do not fit together.
    """

    features: FeatureMap
    weights: NDArray[np.float32]
    bias: NDArray[np.float32]

    def __post_init__(self) -> None:
        wanted = (self.features.length, 4)
        if self.weights.shape != wanted or self.bias.shape != (4,):
            raise ValueError(
                f"BoxRefinement needs weights {wanted} and bias (4,). "
                f"Got {self.weights.shape} and {self.bias.shape} instead."
            )

    def features_of(self, picture: Picture, boxes: FloatArray) -> NDArray[np.float32]:
        """Features of boxes, shape (n, h).

        Args:
            picture: BGR, uint8; its border is replicated.
            boxes: shape (n, 4), px.
        """
        patches = np.empty((len(boxes), SIDE, SIDE, 3), dtype=np.uint8)
        for patch, box in zip(patches, boxes, strict=True):
            patch[:] = cut_box(picture, box)
        return self.features(describe_patches(patches))

    def steps_of(self, features: NDArray[np.float32]) -> FloatArray:
        """Steps (n, 4) for features (n, h); a row does not depend on the others."""
        return linear(features, self.weights, self.bias).astype(np.float64)

    def refine(self, picture: Picture, boxes: FloatArray, passes: int = 1) -> FloatArray:
        """Boxes (n, 4) moved onto their sign's edges; those that reach beyond the picture stay as they are.

        The regression predicts the mean step, so it moves a box too little when it is unsure. A second pass starts
        from a better place and covers most of the rest.

        Args:
            picture: BGR, uint8.
            boxes: shape (n, 4), px.
            passes: number of passes, >= 0.
        """
        height, width = picture.shape[:2]
        out = boxes.copy()
        for _ in range(passes):
            inside = np.flatnonzero((out[:, :2] >= 0).all(axis=1) & (out[:, 2:] <= [width, height]).all(axis=1))
            if not len(inside):
                break
            out[inside] = move_edges(out[inside], self.steps_of(self.features_of(picture, out[inside])))
        return out

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]]) -> BoxRefinement:
        """Make it from a model component's arrays ``outline_*`` (see :meth:`to_arrays`).

        Raises:
            KeyError: an array is missing.
            ValueError: shapes do not fit together.
        """
        names = ("outline_weights", "outline_bias")
        weights, bias = (np.ascontiguousarray(arrays[name], dtype=np.float32) for name in names)
        return cls(FeatureMap.from_arrays(arrays, "outline_"), weights, bias)

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Arrays from which :meth:`from_arrays` makes the same regression; matrices as float16."""
        return {
            **self.features.to_arrays("outline_"),
            "outline_weights": self.weights.astype(np.float16),
            "outline_bias": self.bias,
        }


def cut_box(picture: Picture, box: FloatArray) -> Picture:
    """A box, shape (4,), with a border of a tenth, stretched to a patch of 48x48 px; BGR, uint8."""
    width, height = np.maximum(box[2:] - box[:2], 1e-3)
    stretch = np.sqrt(height / width)
    return cut_patch(picture, box, _BOX_SIDE_PX, SIDE, np.diag([stretch, 1 / stretch]))


def move_edges(boxes: FloatArray, steps: FloatArray) -> FloatArray:
    """Boxes (n, 4) moved and resized.

    Args:
        boxes: shape (n, 4), px.
        steps: shape (n, 4): displacement of the centre in widths and heights, natural logarithms of the factors on
            width and height. Clipped to [-0.3, 0.3].
    """
    return box_steps.move(boxes, steps, box_steps.size_of(boxes), _MAX_STEP)


def steps_between(boxes: FloatArray, truth: FloatArray) -> FloatArray:
    """Steps (n, 4) by which :func:`move_edges` moves boxes (n, 4) onto the true boxes (n, 4)."""
    return box_steps.steps_between(boxes, truth, box_steps.size_of(boxes))
