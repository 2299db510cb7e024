"""Removes the lasting vertical part of the camera's shift: a camera on a car does not tilt for seconds."""

from __future__ import annotations

from collections import deque

__all__ = ["Level"]

_UNMEASURED = 1e-6
"""A shift below this, px, is that of a repeated picture or one that could not be reported."""

_LEAST_STEP = 0.25
"""A frame that comes sooner after the one before than so many intervals says nothing of a shift an interval: its clock
is too coarse or jumped back, and divided by next to no time a shift of a pixel would outweigh all others."""


class Level:
    """Subtracts the lasting vertical part of the picture's global shift.

    A car nods over bumps, but its mean pitch rate over a second or two is almost zero; only curves turn a camera for
    longer, and they turn it sideways. A lasting vertical shift is therefore no rotation. It is flow from a focus of
    expansion above or below the assumed one (a camera that is not level), and such flow depends on the depth.

    Args:
        frames: the mean is taken over so many frames; 0 leaves the shift as it is.
    """

    def __init__(self, frames: int) -> None:
        self._lifts: deque[float] = deque(maxlen=frames)

    def forget(self) -> None:
        """Start anew: the frames to come are judged by themselves."""
        self._lifts.clear()

    def of(self, shift: tuple[float, float], dt: float = 1.0) -> tuple[float, float]:
        """The shift of the next frame, px, less the mean vertical shift up to it.

        The mean of the first frames is drawn towards zero, ``sum / (n + 1)``: one frame alone may be a bump. No more
        is taken out than was measured, so that a car that stops is not taken for one that nods. A shift that was not
        measured passes and is not counted; nor is one counted that came in next to no time.

        Args:
            shift: of the picture since the frame before, px.
            dt: time since then in nominal frame intervals, > 0; the mean is one of shifts an interval.
        """
        if self._lifts.maxlen == 0 or max(abs(shift[0]), abs(shift[1])) < _UNMEASURED:
            return shift
        if dt >= _LEAST_STEP:
            self._lifts.append(shift[1] / dt)
        lasting = dt * sum(self._lifts) / (len(self._lifts) + 1)
        low, high = sorted((0.0, shift[1]))
        return shift[0], shift[1] - min(max(lasting, low), high)
