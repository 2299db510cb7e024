"""The refine-and-verify stage: corrects the box of each candidate and scores it with a larger ensemble.

The cascade works on a grid of whole cells and scales. The stage cuts each candidate out again with more of its
surroundings. A linear regression moves and stretches the box (one step of supervised descent, Xiong & De la Torre
2013). The window is cut again at the corrected place and moved once more. A larger boosted ensemble, trained on such
corrected candidates, scores it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.channels.compute import CHANNELS
from tsr_engine.channels.quantise import channel_bytes
from tsr_engine.channels.smooth import smooth
from tsr_engine.detection.patch import cut_patch
from tsr_engine.detection.trees import TreeEnsemble
from tsr_engine.geometry import box_steps
from tsr_engine.linear_algebra import product
from tsr_engine.records import FloatArray, Picture

SIGN: Final = 28.0
"""Side of the sign in the patch, px."""
CELLS: Final = 20
"""Side of the window, cells of 2 px: 43 % more than the sign."""
MARGIN: Final = 10
"""Margin around the window for the channels' filters, px."""
FEATURES: Final = CHANNELS * CELLS * CELLS


@dataclass(frozen=True, slots=True)
class RefineStage:
    """Two regressions and a verifying ensemble.

    Attributes:
        weights: shape (2, FEATURES, 4), float32: for each step, from features in [0, 1] to (dx, dy) in sides and
            (log w, log h), relative to the current square box.
        biases: shape (2, 4), float32.
        verifier: ensemble over the FEATURES features of the box after the first step.
    """

    weights: NDArray[np.float32]
    biases: NDArray[np.float32]
    verifier: TreeEnsemble

    def refine_and_verify(self, picture: Picture, boxes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Refined boxes (n, 4), and the verifier's scores (n,) in half log-odds, of candidates (n, 4)."""
        if not len(boxes):
            return np.zeros((0, 4)), np.zeros(0)
        first = features_of(picture, boxes)
        middle = self.step(0, boxes, first)
        second = features_of(picture, middle)
        refined = self.step(1, middle, second)
        return refined, self.verifier.scores(second) / 256.0

    def step(self, number: int, boxes: FloatArray, features: NDArray[np.uint8]) -> FloatArray:
        """Boxes (n, 4) after step 0 or 1, from their features (n, FEATURES)."""
        # Features are whole bytes and weights were stored in 16 bits, so sums in 64 bits have no rounding.
        steps = product(features.astype(np.float64), self.weights[number].astype(np.float64)) / 255.0
        return move(boxes, steps + self.biases[number])


def features_of(picture: Picture, boxes: FloatArray) -> NDArray[np.uint8]:
    """Features of the windows around boxes, shape (n, FEATURES), uint8."""
    side = 2 * (CELLS + MARGIN)
    out = np.empty((len(boxes), FEATURES), np.uint8)
    # The kernels have a fixed cost for each row, so the patches stand side by side. They touch at columns of their
    # margins, so the filters do not mix the windows.
    strip = np.concatenate([cut_patch(picture, box, SIGN, side) for box in boxes], axis=1)
    cells = smooth(channel_bytes(strip, 2))
    first = MARGIN // 2
    for i in range(len(boxes)):
        left = i * side // 2 + first
        out[i] = cells[:, first : first + CELLS, left : left + CELLS].reshape(-1)
    return out


def move(boxes: FloatArray, steps: FloatArray) -> FloatArray:
    """Boxes (n, 4) moved and resized by steps (n, 4), relative to each box's mean side."""
    return box_steps.move(boxes, steps, box_steps.mean_side(boxes), 0.4)


def steps_to(boxes: FloatArray, truth: FloatArray) -> FloatArray:
    """Steps (n, 4) by which :func:`move` moves boxes (n, 4) onto the true boxes (n, 4)."""
    return box_steps.steps_between(boxes, truth, box_steps.mean_side(boxes))
