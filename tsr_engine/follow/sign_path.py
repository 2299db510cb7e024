"""The path of a sign through the picture: the looming filter, started by a drawn box, in either direction of time."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from tsr_engine.follow.records import Direction
from tsr_engine.geometry.boxes import to_cxcywh, to_xyxy
from tsr_engine.protocols import MeasurementQuality, MotionState
from tsr_engine.records import FloatArray
from tsr_engine.tracking.measurement_noise import MeasurementNoise
from tsr_engine.tracking.motion_looming import ASPECT, CX, CY, LoomingMotion, LoomingNoise, Q

_INITIAL_GROWTH: Final = 0.015
"""Initial growth per frame, as in tracking; negative backwards."""
_GROWTH_SPREAD: Final = 0.08
_PROCESS: Final = LoomingNoise(
    growth=0.002, aspect=0.001, centre=0.03, centre_px=1.0, drift_px=0.5, foe_spread=0.06, growth_spread=_GROWTH_SPREAD
)
_NOISE: Final = MeasurementNoise(centre=0.5, size=1.0)
"""Noise per unit of a match's error: centres are twice as exact as sizes."""
_ANCHOR_CENTRE_ERROR_PX: Final = 0.5
_ANCHOR_SIZE_ERROR: Final = 0.01
_ANCHOR_ASPECT_ERROR: Final = 0.02
"""Errors of a person's box: px of its centre, shares of its size and of its shape."""


class SignPath:
    """A filter that starts on an anchor.

    Args:
        box: the anchor's box, shape (4,), px.
        size: width and height of the pictures, px.
        direction: direction of time.
    """

    def __init__(self, box: FloatArray, size: tuple[int, int], direction: Direction) -> None:
        sign = 1.0 if direction == "forward" else -1.0
        self._model = LoomingMotion(_NOISE, replace(_PROCESS, growth_start=sign * _INITIAL_GROWTH))
        state = self._model.initiate(to_cxcywh(box), *size)
        covariance = state.covariance.copy()
        covariance[CX, CX] = covariance[CY, CY] = _ANCHOR_CENTRE_ERROR_PX**2
        covariance[Q, Q] = (_ANCHOR_SIZE_ERROR * state.mean[Q]) ** 2
        covariance[ASPECT, ASPECT] = (_ANCHOR_ASPECT_ERROR * state.mean[ASPECT]) ** 2
        self._state = MotionState(state.mean, covariance)

    def predict(self, frames: float, shift: tuple[float, float]) -> None:
        """Advance by a number of frames in which the camera's rotation shifted the picture by ``shift`` px."""
        self._state = self._model.predict(self._state, frames, shift)

    def correct(self, box: FloatArray, error: float) -> None:
        """Update by a measured box (4,), px; ``error`` is the standard error of the natural logarithm of its size."""
        self._state = self._model.update(self._state, to_cxcywh(box), MeasurementQuality(error, error))

    @property
    def box(self) -> FloatArray:
        """Shape (4,), px; may reach beyond the picture."""
        return to_xyxy(self._model.box_of(self._state))

    @property
    def place_error(self) -> float:
        """Standard deviation of the centre along its less certain axis, px."""
        return math.sqrt(max(self._state.covariance[CX, CX], self._state.covariance[CY, CY], 0.0))

    @property
    def size_error(self) -> float:
        """Standard deviation of the natural logarithm of the size."""
        return math.sqrt(max(self._state.covariance[Q, Q], 0.0)) / float(self._state.mean[Q])
