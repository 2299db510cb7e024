"""Estimates the height of the focus of expansion of a car's camera from the flow of a drive.

If a car drives straight, all flow is along the rays from the true focus of expansion (FOE). Relative to an assumed
focus that lies ``delta`` px too high, the same flow has a vertical shift of ``-delta`` times the growth. Bumps shift
the picture, too. Over a drive, however, their sum is only the difference between the first and the last pitch, while
the shifts by a wrong focus add up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from tsr_engine.records import FloatArray
from tsr_engine.tracking.camera_shift import fit_shift

MIN_APPROACH = 0.2
"""Least sum of the growths over a drive for an estimate: the distance to the scene shrinks by about a fifth.

In a shorter approach, a constant error of a hundredth of a pixel in the flow moves the focus by some hundredths of the
height, and the scatter does not show it."""
MAX_STANDARD_ERROR = 0.1
"""Largest standard error of an estimate, share of the height. The assumption of a level camera is better than that."""
_MIN_Y, _MAX_Y = -0.5, 1.5
"""Limits of the search, shares of the height."""
_RESOLUTION = 1e-3
"""Resolution of the search, share of the height."""


@dataclass(frozen=True, slots=True)
class Focus:
    """The height of a camera's focus of expansion.

    Attributes:
        y: share of the picture's height, 0 at the top.
        error: standard error of ``y`` from the scatter of the frames, share of the height.
        frames: number of pairs of pictures with flow.
        approach: sum of the growths over the drive.
    """

    y: float
    error: float
    frames: int
    approach: float


def find_focus(
    flows: Sequence[tuple[FloatArray, FloatArray]], width: float, height: float, x: float = 0.5
) -> Focus | None:
    """Find the height of the focus of expansion for which the flow of a drive has no mean vertical shift.

    Args:
        flows: points and their flow, each of shape (n, 2) in px, for every pair of pictures.
        width: width of the picture, px.
        height: height of the picture, px.
        x: horizontal position of the focus, share of the width. It is not estimated, because a long curve has the same
            effect as a camera that points sideways.

    Returns:
        The focus. None if the approach is too short (``MIN_APPROACH``), the camera shakes too much
        (``MAX_STANDARD_ERROR``), or the shift has the same sign for every height.
    """

    def fit_shifts(y: float) -> tuple[FloatArray, float]:
        """Vertical shift of each pair, px, and the sum of the growths, for a focus at that share of the height."""
        fits = [fit_shift(points - [x * width, y * height], flow) for points, flow in flows]
        return np.array([shift[1] for shift, _ in fits]), sum(growth for _, growth in fits)

    def mean_shift(y: float) -> float:
        return float(fit_shifts(y)[0].mean())

    if not flows or mean_shift(_MIN_Y) >= 0.0 or mean_shift(_MAX_Y) <= 0.0:
        return None
    y = float(brentq(mean_shift, _MIN_Y, _MAX_Y, xtol=_RESOLUTION))
    shifts, approach = fit_shifts(y)
    slope = (mean_shift(y + 0.05) - mean_shift(y - 0.05)) / 0.1
    if approach < MIN_APPROACH or slope <= 0.0:
        return None
    error = _error_of_mean(shifts) / slope
    return Focus(y, error, len(shifts), approach) if error <= MAX_STANDARD_ERROR else None


def _error_of_mean(values: FloatArray) -> float:
    """Standard error of the mean of consecutive values, from the means of batches.

    Shifts by the nodding of a car are not independent: each nod down is followed by one up. So their sum scatters far
    less than the sum of independent values.
    """
    means = np.array([batch.mean() for batch in np.array_split(values, max(2, round(np.sqrt(len(values)))))])
    return float(means.std(ddof=1) / np.sqrt(len(means)))
