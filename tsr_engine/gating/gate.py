"""The gate: decides whether a predicted crop shows the sign with confidence (Eq. 3)."""

from __future__ import annotations

import math

import numpy as np

from tsr_engine.gating.perceptual_hash import HashMemory
from tsr_engine.gating.symmetry import Symmetry, SymmetryDetector
from tsr_engine.params.gate import GateParams
from tsr_engine.records import FloatArray, GateVerdict, Picture


class Gate:
    """``L_positive(f_k) = symm(f_k) * p_ph(mean of earlier crops, f_k) * p_pos(f_{k-1}, f_k)``, confident below tau.

    A gate has no state. The caller keeps the :class:`HashMemory` of each track.
    """

    def __init__(self, params: GateParams) -> None:
        self.params = params
        self.margin = params.gate_margin
        """Border that crops must have on each side of the box, as a share of the box's side."""
        self._symmetry = SymmetryDetector(params.symmetry_size, params.symmetry_contrast)

    def remember(self, memory: HashMemory, crop: Picture) -> HashMemory:
        """The memory with the crop of one more result of the track."""
        return memory.add(crop, self.params.hash_memory)

    def judge(
        self,
        crop: Picture,
        memory: HashMemory,
        centre: FloatArray,
        previous_centre: FloatArray,
        side: float | None = None,
        shift: tuple[float, float] = (0.0, 0.0),
    ) -> GateVerdict:
        """Judge one predicted crop.

        The product of Eq. 3 is 0 for a crop that equals its memory (``p_ph = 0``) or has not moved (``p_pos = 0``).
        Such a crop is confident even if its symmetry is weak, as the equation states.

        Args:
            crop: BGR, uint8: the predicted box with its margin.
            memory: the track's earlier crops, cut with the same margin.
            centre: shape (2,), the candidate's centre, px.
            previous_centre: shape (2,), the centre of the previous frame's result, px.
            side: the candidate's mean side, px; unset: from the crop and its margin.
            shift: global camera shift of the picture since the previous frame, px; used if ``position_camera``.

        Returns:
            The verdict. A candidate whose place is not finite, or whose crop has no pixels, is never confident.

        Raises:
            ValueError: the memory is empty.
        """
        appearance = float(memory.distance(crop))
        magnitude = self.symmetry(crop).magnitude
        symmetry = 1.0 / max(magnitude, self.params.symmetry_floor)
        if side is None:
            side = (crop.shape[0] + crop.shape[1]) / (2 + 4 * self.margin)
        position = self._distance(centre, previous_centre, side, shift)
        # 0 * inf is undefined, so an unusable candidate gets an infinite distance.
        usable = math.isfinite(position) and crop.size > 0
        product = symmetry * appearance * (position + self.params.position_offset) if usable else math.inf
        return GateVerdict(magnitude, symmetry, appearance, position, product, product < self.params.tau)

    def symmetry(self, crop: Picture) -> Symmetry:
        """The mirror axis of a crop without its margin, so that background does not count.

        Coordinates are px of the inner part, which begins at :meth:`border`.
        """
        x, y = self.border(crop)
        height, width = crop.shape[:2]
        return self._symmetry.measure(crop[y : height - y, x : width - x])

    def border(self, crop: Picture) -> tuple[int, int]:
        """Columns and rows of margin on each side of a crop."""
        share = self.margin / (1 + 2 * self.margin)
        return round(crop.shape[1] * share), round(crop.shape[0] * share)

    def _distance(self, centre: FloatArray, previous: FloatArray, side: float, shift: tuple[float, float]) -> float:
        moved = np.asarray(centre, dtype=np.float64) - np.asarray(previous, dtype=np.float64)
        if self.params.position_camera:
            moved = moved - np.asarray(shift, dtype=np.float64)
        distance = math.hypot(float(moved[0]), float(moved[1]))
        if self.params.position_unit == "side":
            distance /= max(side, 1.0)
        return distance if math.isfinite(distance) else math.inf
