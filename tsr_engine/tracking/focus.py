"""Estimates the height of the focus of expansion of a car's camera from the flow of a drive.

Seen from the true focus of expansion (FOE), a car that drives straight has flow along the rays only. About an assumed
focus that lies ``delta`` px too high, the same flow has a vertical shift of ``-delta`` times the growth. Bumps shift
the picture too, but over a drive their sum is only the difference of the first and last pitch, while the part of the
focus adds up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from tsr_engine.records import FloatArray
from tsr_engine.tracking.camera_shift import fit_shift

__all__ = ["LARGEST_ERROR", "LEAST_APPROACH", "Focus", "find_focus"]

LEAST_APPROACH = 0.2
"""Sum of the growths over a drive below which nothing is said: what is seen has come nearer by less than a fifth.

Flow that is off by the same hundredth of a pixel in every frame moves the focus of a short approach by some hundredths
of the height, and no scatter tells."""
LARGEST_ERROR = 0.1
"""Standard error, share of the height, above which nothing is said: a camera that is mounted level is known better."""
_HIGHEST, _LOWEST = -0.5, 1.5
"""Between these a focus is looked for, shares of the height."""
_FINE = 1e-3
"""... and found to this share of the height."""


@dataclass(frozen=True, slots=True)
class Focus:
    """The height of a camera's focus of expansion.

    Attributes:
        y: share of the picture's height, 0 at the top.
        error: its standard error by the scatter of the frames, share of the height.
        frames: pairs of pictures with flow.
        approach: sum of the growths: how much nearer everything has come.
    """

    y: float
    error: float
    frames: int
    approach: float


def find_focus(
    flows: Sequence[tuple[FloatArray, FloatArray]], width: float, height: float, x: float = 0.5
) -> Focus | None:
    """The height of the focus of expansion about which the flow of a drive has no lasting vertical shift.

    Args:
        flows: points and their flow, each of shape (n, 2) in px, for every pair of pictures.
        width: of the picture, px.
        height: of the picture, px.
        x: of the focus, share of the width. It is not looked for: a curve shifts the picture for as long as a camera
            that looks aside.

    Returns:
        None where the camera has come too little nearer to what it sees (``LEAST_APPROACH``), shakes too much for
        that (``LARGEST_ERROR``), or the shift has one sign wherever the focus is put.
    """

    def fitted(y: float) -> tuple[FloatArray, float]:
        """Vertical shift of each pair about a focus at that share of the height, px, and the sum of the growths."""
        fits = [fit_shift(points - [x * width, y * height], flow) for points, flow in flows]
        return np.array([shift[1] for shift, _ in fits]), sum(growth for _, growth in fits)

    def lasting(y: float) -> float:
        return float(fitted(y)[0].mean())

    if not flows or lasting(_HIGHEST) >= 0.0 or lasting(_LOWEST) <= 0.0:
        return None
    y = float(brentq(lasting, _HIGHEST, _LOWEST, xtol=_FINE))
    lifts, approach = fitted(y)
    slope = (lasting(y + 0.05) - lasting(y - 0.05)) / 0.1
    if approach < LEAST_APPROACH or slope <= 0.0:
        return None
    error = _error_of_mean(lifts) / slope
    return Focus(y, error, len(lifts), approach) if error <= LARGEST_ERROR else None


def _error_of_mean(lifts: FloatArray) -> float:
    """Standard error of the mean of consecutive values, by the means of batches of them.

    A car that nods down comes up again: its shifts are not independent, and their sum scatters far less than as many
    independent ones would.
    """
    means = np.array([batch.mean() for batch in np.array_split(lifts, max(2, round(np.sqrt(len(lifts)))))])
    return float(means.std(ddof=1) / np.sqrt(len(means)))
