"""Constant velocity of centre and size: the usual filter of box trackers.

filterpy computes the process noise. The two steps are own code, because filterpy multiplies by BLAS, whose last digits
depend on the processor (see :mod:`tsr_engine.linear_algebra`). A test compares them with filterpy's filter.
"""

from __future__ import annotations

import numpy as np

from tsr_engine.linear_algebra import product
from tsr_engine.protocols import FULL_QUALITY, MeasurementQuality, MotionState
from tsr_engine.records import FloatArray
from tsr_engine.tracking.kalman import propagate_covariance, update_covariance
from tsr_engine.tracking.measurement_noise import MeasurementNoise

_H = np.eye(4, 8)


class ConstantVelocityMotion:
    """Kalman filter over ``cx, cy, w, h`` and their velocities, 8 states, px and px per frame.

    The process noise is a discrete white acceleration; its standard deviation is a share of the box's size.

    Args:
        noise: measurement noise.
        process: standard deviation of the acceleration per frame^2, as a share of the size.
    """

    name = "constant_velocity"

    def __init__(self, noise: MeasurementNoise, process: float = 0.01) -> None:
        from filterpy.common import Q_discrete_white_noise  # imports scipy.stats, which takes half a second

        self._noise = noise
        self._process = process
        self._white_noise = Q_discrete_white_noise

    def initiate(self, measurement: FloatArray, width: int, height: int) -> MotionState:
        """State at rest; the standard deviation of the velocity is a tenth of the size per frame."""
        z = np.asarray(measurement, dtype=np.float64)
        sizes = np.array([z[2], z[3], z[2], z[3]])
        P = np.zeros((8, 8))
        P[:4, :4] = self._noise.covariance(z[2], z[3])
        P[4:, 4:] = np.diag((0.1 * sizes) ** 2)
        return MotionState(np.concatenate([z, np.zeros(4)]), P)

    def predict(
        self, state: MotionState, dt: float, shift: tuple[float, float], focus_y: float | None = None
    ) -> MotionState:
        """``x + v dt``, plus the camera shift on the centre."""
        F = np.eye(8)
        F[:4, 4:] = dt * np.eye(4)
        w, h = state.mean[2:4]
        block = self._white_noise(dim=2, dt=dt, var=1.0)
        Q = np.kron(block, np.diag((self._process * np.array([w, h, w, h])) ** 2))
        x = state.mean.copy()
        x[:4] += dt * x[4:]
        x[:2] += shift
        x[2:4] = np.maximum(x[2:4], 1.0)
        return MotionState(x, propagate_covariance(state.covariance, F) + Q)

    def update(
        self, state: MotionState, measurement: FloatArray, quality: MeasurementQuality = FULL_QUALITY
    ) -> MotionState:
        """Standard Kalman update."""
        R = self._noise.covariance(state.mean[2], state.mean[3], quality)
        K, P = update_covariance(state.covariance, _H, R)
        innovation = np.asarray(measurement, dtype=np.float64) - state.mean[:4]
        x = state.mean + product(K, innovation[:, None])[:, 0]
        x[2:4] = np.maximum(x[2:4], 1.0)
        return MotionState(x, P)

    def box_of(self, state: MotionState) -> FloatArray:
        """``cx, cy, w, h``, shape (4,)."""
        return state.mean[:4].copy()

    def innovation(self, state: MotionState) -> FloatArray:
        """``H P H' + R``, shape (4, 4), px^2."""
        return np.asarray(state.covariance[:4, :4] + self._noise.covariance(state.mean[2], state.mean[3]))
