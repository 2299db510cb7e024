"""Removes the lasting vertical part of the camera's shift: a camera on a car does not tilt for seconds."""

from __future__ import annotations

from collections import deque

_MIN_SHIFT_PX = 1e-6
"""px: a smaller shift means a repeated picture or an unknown shift."""

_MIN_STEP = 0.25
"""Least time between two frames, in intervals, for a shift to count. A shorter time means a coarse clock or one that
was set back; the shift of one pixel, divided by it, would outweigh all others."""


class VerticalDriftFilter:
    """Subtracts the lasting vertical part of the picture's global shift.

    A car nods over bumps, but its mean pitch rate over a second or two is almost zero. Only curves turn a camera for
    longer, and they turn it sideways. A lasting vertical shift is therefore not a rotation. Its cause is a focus of
    expansion above or below the assumed one (a camera that is not level), and such flow depends on the depth.

    Args:
        frames: number of frames of the mean; 0 leaves the shift unchanged.
    """

    def __init__(self, frames: int) -> None:
        self._vertical_shifts: deque[float] = deque(maxlen=frames)

    def reset(self) -> None:
        """Forget all earlier shifts."""
        self._vertical_shifts.clear()

    def remove_drift(self, shift: tuple[float, float], dt: float = 1.0) -> tuple[float, float]:
        """The shift of the next frame, px, minus the mean vertical shift of the last frames, this one included.

        The mean is ``sum / (n + 1)``, which is small for the first frames, since a single shift may be a bump. At most
        the measured shift is subtracted, so that the result of a car that stops is zero. An unknown shift is returned
        unchanged and does not count; a shift after a very short time does not count either.

        Args:
            shift: shift of the picture since the last frame, px.
            dt: time since then in nominal frame intervals, > 0; the mean is of shifts per interval.
        """
        if self._vertical_shifts.maxlen == 0 or max(abs(shift[0]), abs(shift[1])) < _MIN_SHIFT_PX:
            return shift
        if dt >= _MIN_STEP:
            self._vertical_shifts.append(shift[1] / dt)
        drift = dt * sum(self._vertical_shifts) / (len(self._vertical_shifts) + 1)
        low, high = sorted((0.0, shift[1]))
        return shift[0], shift[1] - min(max(drift, low), high)
