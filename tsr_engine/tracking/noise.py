"""Measurement noise of a detector's boxes: it grows with the box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsr_engine.records import FloatArray


@dataclass(frozen=True, slots=True)
class MeasurementNoise:
    """Standard deviations of ``cx, cy, w, h`` as shares of the box's own size.

    Attributes:
        centre: std of the centre, share of width (x) and height (y).
        size: std of width and height, share of themselves. Independent edges give ``size = 2 centre``.
    """

    centre: float = 0.07
    size: float = 0.14

    def covariance(self, width: float, height: float, factor: float = 1.0) -> FloatArray:
        """R for a box of width x height px, shape (4, 4), px^2; ``factor`` scales the standard deviations."""
        std = np.array([self.centre * width, self.centre * height, self.size * width, self.size * height]) * factor
        return np.diag(std**2)
