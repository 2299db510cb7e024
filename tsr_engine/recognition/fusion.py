"""Fusion of the class probabilities of one physical sign over its frames (Eq. 4, 5)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsr_engine.params.fusion import FusionParams
from tsr_engine.recognition.gtsrb_classes import CLASS_COUNT
from tsr_engine.records import FloatArray, Recognition

FLOOR = 1e-12
"""Least weight, relative to the peak, so that a track whose sizes are all far from ``fusion_scale`` has votes."""


def frame_weight(scale: float, params: FusionParams) -> float:
    """``w_t`` of one frame.

    * ``scale``: Eq. 5, ``exp(-(s_t - s_c)^2 / (2 delta^2)) / (delta sqrt(2 pi))``;
    * ``clamped``: Eq. 5 below ``s_c``, its peak from ``s_c`` on, since larger crops are not harder to read;
    * ``equal``: 1.

    Args:
        scale: ``s_t``, the crop's side in px, finite and >= 0.
        params: mode, ``delta`` and ``s_c``.

    Raises:
        ValueError: the scale is negative or not finite.
    """
    if not (math.isfinite(scale) and scale >= 0):
        raise ValueError(f"The scale must be finite and >= 0 px. Got {scale} instead.")
    if params.fusion_mode == "equal":
        return 1.0
    distance = scale - params.fusion_scale
    if params.fusion_mode == "clamped":
        distance = min(distance, 0.0)
    peak = 1.0 / (params.fusion_delta * math.sqrt(2.0 * math.pi))
    return peak * max(math.exp(-(distance**2) / (2.0 * params.fusion_delta**2)), FLOOR)


@dataclass(frozen=True, slots=True, eq=False)
class Fusion:
    """The votes of one track up to now; immutable."""

    params: FusionParams
    votes: FloatArray
    """Shape (c,): ``sum_t w_t P(c | x_t)`` (Eq. 4)."""

    @classmethod
    def start(cls, params: FusionParams, count: int = CLASS_COUNT) -> Fusion:
        """The state before the first frame, for ``count`` >= 2 classes."""
        votes = np.zeros(count)
        votes.setflags(write=False)
        return cls(params, votes)

    def update(self, probabilities: NDArray[np.generic], scale: float) -> tuple[Fusion, Recognition]:
        """Add one frame.

        Args:
            probabilities: ``P(c | x_t)``, shape (c,).
            scale: ``s_t``, the crop's side in px.

        Returns:
            The next state and the frame's record; ``class_id`` is the argmax of Eq. 4, the lower id on a tie.

        Raises:
            ValueError: the probabilities have another shape, are negative, not finite or all zero, or the scale is
                negative or not finite.
        """
        p = np.asarray(probabilities, dtype=np.float32)
        if p.shape != self.votes.shape:
            raise ValueError(f"Probabilities must have shape {self.votes.shape}. Got {p.shape} instead.")
        if not (np.isfinite(p).all() and (p >= 0).all() and p.sum() > 0):
            raise ValueError("Probabilities must be finite, >= 0 and not all zero.")
        weight = frame_weight(scale, self.params)
        votes = self.votes + weight * p.astype(np.float64)
        votes.setflags(write=False)
        runner_up, class_id = _best_two(votes)
        record = Recognition(
            probabilities=p,
            scale=float(scale),
            weight=weight,
            votes=votes,
            class_id=class_id,
            share=float(votes[class_id] / votes.sum()),
            runner_up=runner_up,
        )
        return Fusion(self.params, votes), record


def _best_two(votes: FloatArray) -> tuple[int, int]:
    """Runner-up and winner; the lower class number first on ties."""
    order = np.argsort(-votes, kind="stable")
    return int(order[1]), int(order[0])
