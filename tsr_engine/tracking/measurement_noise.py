"""Measurement noise of a detector's boxes: it grows with the box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsr_engine.protocols import FULL_QUALITY, MeasurementQuality
from tsr_engine.records import FloatArray

_UNKNOWN_EDGE_STD = 10.0
"""Standard deviation of a cut-off edge, in sides of the box."""


@dataclass(frozen=True, slots=True)
class MeasurementNoise:
    """Standard deviations of ``cx, cy, w, h`` as shares of the box's own size.

    Attributes:
        centre: standard deviation of the centre, share of width (x) and height (y).
        size: standard deviation of width and height, share of each. Independent edges give ``size = 2 centre``.
    """

    centre: float = 0.07
    size: float = 0.14

    def covariance(self, width: float, height: float, quality: MeasurementQuality = FULL_QUALITY) -> FloatArray:
        """R for a box of width x height px, shape (4, 4), px^2.

        Args:
            width: width of the box, px.
            height: height of the box, px.
            quality: quality of the measurement. A cut-off edge gets a standard deviation of several sides. It adds
                correlated errors to centre and size, so that only the visible edge is measured.
        """
        centre, size, cut = self.centre * quality.centre, self.size * quality.size, quality.cut
        std = np.array([centre * width, centre * height, size * width, size * height])
        R = np.diag(std**2)
        for axis, side in ((0, width), (1, height)):
            if cut[axis] or cut[axis + 2]:
                visible = std[axis] ** 2 + std[axis + 2] ** 2 / 4.0
                low, high = (((_UNKNOWN_EDGE_STD * side) ** 2 if cut[edge] else visible) for edge in (axis, axis + 2))
                R[axis, axis] = (low + high) / 4.0
                R[axis, axis + 2] = R[axis + 2, axis] = (high - low) / 2.0
                R[axis + 2, axis + 2] = low + high
        return R
