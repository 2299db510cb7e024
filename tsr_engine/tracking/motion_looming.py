"""Looming: the motion of a sign that a driving camera approaches, filtered in inverse width.

A sign of metric width W at depth Z is ``w = f W / Z`` px wide. At constant speed Z falls linearly, so
``q = 1 / w`` is linear in time where ``w`` and the centre are hyperbolic. The centre moves along the ray from
the focus of expansion (FOE), its distance from it in proportion to ``w``; a rotating camera shifts the whole
picture on top. Constant displacement and constant velocity lag behind such a target; this model does not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from tsr_engine.linear_algebra import product
from tsr_engine.protocols import FULL_QUALITY, MeasurementQuality, MotionState
from tsr_engine.records import FloatArray
from tsr_engine.tracking.kalman import propagate_covariance, update_covariance
from tsr_engine.tracking.measurement_noise import MeasurementNoise

CX, CY, Q, RATE, ASPECT, VX, VY, FX, FY = range(9)
"""Indices of the state: centre, inverse width, its rate, height / width, drift, FOE; in px and frames."""
_STATES = 9
_MAX_WIDTH, _MIN_WIDTH = 4000.0, 2.0
_ASPECT_RANGE = (0.05, 20.0)


@dataclass(frozen=True, slots=True)
class LoomingNoise:
    """Process noise of the looming model, per frame; see ``TrackingParams`` for each meaning."""

    growth_start: float = 0.015
    growth_spread: float = 0.05
    growth: float = 0.0002
    scale: float = 0.004
    aspect: float = 0.004
    centre: float = 0.05
    centre_px: float = 0.3
    drift_px: float = 0.1
    drift_decay: float = 0.95
    foe_spread: float = 0.03


class LoomingMotion:
    """Extended Kalman filter over ``cx, cy, q, dq/dt, h/w``, a slow drift of the centre, and the FOE.

    ``q' = q + dq dt`` and ``c' = foe + (c - foe) q / q' + drift dt + shift``. The drift is the motion that the
    picture's shift does not explain; it decays by ``drift_decay`` per frame. The FOE starts at its assumed place, with
    a standard deviation of ``foe_spread`` of the picture's width and height; the centre's path then corrects it.
    The measurement is ``cx, cy, 1 / q, aspect / q``.

    Args:
        noise: measurement noise.
        process: process noise.
        foe: focus of expansion as shares of the picture's width and height.
    """

    name = "looming"

    def __init__(
        self, noise: MeasurementNoise, process: LoomingNoise | None = None, foe: tuple[float, float] = (0.5, 0.5)
    ) -> None:
        self._noise = noise
        self._process = process or LoomingNoise()
        self._foe = foe

    def initiate(self, measurement: FloatArray, width: int, height: int) -> MotionState:
        """The state after the first measurement, with the usual growth of a sign that the camera approaches."""
        cx, cy, w, h = (float(v) for v in measurement)
        p = self._process
        q = 1.0 / w
        mean = np.array([cx, cy, q, -p.growth_start * q, h / w, 0.0, 0.0, self._foe[0] * width, self._foe[1] * height])
        n = self._noise
        std = [n.centre * w, n.centre * h, n.size * q, p.growth_spread * q, 1.4 * n.size * h / w]
        drift = p.drift_px / np.sqrt(max(1.0 - p.drift_decay**2, 0.01))
        foe = [p.foe_spread * width, p.foe_spread * height]
        return MotionState(mean, np.diag(np.array([*std, drift, drift, *foe]) ** 2))

    def predict(
        self, state: MotionState, dt: float, shift: tuple[float, float], focus_y: float | None = None
    ) -> MotionState:
        """Time update along the ray from the FOE, then the camera shift.

        Args:
            state: state of the last frame.
            dt: time since then, nominal frame intervals.
            shift: global camera shift since then, px.
            focus_y: row of the FOE in this step, px; the state keeps its own estimate. None: the state's.
        """
        p = self._process
        process = np.array([p.centre, p.centre_px, p.scale, p.growth, p.aspect, p.drift_px, p.drift_decay])
        mean = state.mean.copy()
        if focus_y is not None:
            mean[FY] = focus_y
        predicted, covariance = _time_update(mean, state.covariance, float(dt), shift[0], shift[1], process)
        predicted[FY] = state.mean[FY]
        return MotionState(predicted, covariance)

    def update(
        self, state: MotionState, measurement: FloatArray, quality: MeasurementQuality = FULL_QUALITY
    ) -> MotionState:
        """Measurement update, linearised at the prediction, Joseph form."""
        box = self.box_of(state)
        R = self._noise.covariance(box[2], box[3], quality)
        z = np.asarray(measurement, dtype=np.float64)
        return MotionState(*_measurement_update(state.mean, state.covariance, z, R))

    def box_of(self, state: MotionState) -> FloatArray:
        """``cx, cy, w, h``, shape (4,)."""
        x = state.mean
        return np.array([x[CX], x[CY], 1.0 / x[Q], x[ASPECT] / x[Q]])

    def innovation(self, state: MotionState) -> FloatArray:
        """``H P H' + R``, shape (4, 4), px^2."""
        box = self.box_of(state)
        H = _jacobian(state.mean)
        return np.asarray(propagate_covariance(state.covariance, H) + self._noise.covariance(box[2], box[3]))


@njit(cache=True, nogil=True)
def _time_update(
    x: FloatArray, P: FloatArray, dt: float, shift_x: float, shift_y: float, process: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance after one step.

    ``process`` is the process noise in the order centre, centre_px, scale, growth, aspect, drift_px, drift_decay.
    """
    q = x[Q]
    # A step at most doubles the width, so that a wrong rate cannot make the box huge.
    next_q = max(q + x[RATE] * dt, 0.5 * q, 1.0 / _MAX_WIDTH)
    zoom = q / next_q
    decay = process[6] ** dt
    mean = x.copy()
    F = np.eye(_STATES)
    for c, foe, drift, shift in ((CX, FX, VX, shift_x), (CY, FY, VY, shift_y)):
        ray = x[c] - x[foe]
        mean[c] = x[foe] + ray * zoom + x[drift] * dt + shift
        mean[drift] = x[drift] * decay
        F[c, c] = zoom
        F[c, Q] = ray * (next_q - q) / next_q**2
        F[c, RATE] = -ray * q * dt / next_q**2
        F[c, foe] = 1.0 - zoom
        F[c, drift] = dt
        F[drift, drift] = decay
    F[Q, RATE] = dt
    mean[Q] = min(next_q, 1.0 / _MIN_WIDTH)
    w, h = 1.0 / mean[Q], mean[ASPECT] / mean[Q]
    P = propagate_covariance(P, F)
    P[CX, CX] += dt * ((process[0] * w) ** 2 + process[1] ** 2)
    P[CY, CY] += dt * ((process[0] * h) ** 2 + process[1] ** 2)
    P[Q, Q] += dt * (process[2] * mean[Q]) ** 2
    P[RATE, RATE] += dt * (process[3] * mean[Q]) ** 2
    P[ASPECT, ASPECT] += dt * (process[4] * mean[ASPECT]) ** 2
    P[VX, VX] += dt * process[5] ** 2
    P[VY, VY] += dt * process[5] ** 2
    return mean, P


@njit(cache=True, nogil=True)
def _measurement_update(x: FloatArray, P: FloatArray, z: FloatArray, R: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance after one measurement, linearised at ``x``, Joseph form."""
    w, h = 1.0 / x[Q], x[ASPECT] / x[Q]
    H = _jacobian(x)
    K, P = update_covariance(P, H, R)
    innovation = z - np.array([x[CX], x[CY], w, h])
    mean = x + product(K, innovation.reshape(4, 1))[:, 0]
    mean[Q] = min(max(mean[Q], 1.0 / _MAX_WIDTH), 1.0 / _MIN_WIDTH)
    mean[ASPECT] = min(max(mean[ASPECT], _ASPECT_RANGE[0]), _ASPECT_RANGE[1])
    return mean, P


@njit(cache=True, nogil=True)
def _jacobian(mean: FloatArray) -> FloatArray:
    """d(cx, cy, w, h) / d(state), shape (4, 9)."""
    q, aspect = mean[Q], mean[ASPECT]
    H = np.zeros((4, _STATES))
    H[0, CX] = H[1, CY] = 1.0
    H[2, Q] = -1.0 / q**2
    H[3, Q] = -aspect / q**2
    H[3, ASPECT] = 1.0 / q
    return H
