"""The paper's motion model (section III-B): state [x, y, w, h], F = I, B u = mean displacement."""

from __future__ import annotations

import numpy as np

from tsr_engine.linear_algebra import product
from tsr_engine.protocols import FULL_QUALITY, MeasurementQuality, MotionState
from tsr_engine.records import FloatArray
from tsr_engine.tracking.kalman import update_covariance
from tsr_engine.tracking.measurement_noise import MeasurementNoise


class PaperMotion:
    """Kalman filter whose control input is the whole motion.

    The paper leaves F, B and u open. Here F = I, and ``B u`` is the mean displacement per frame over the last
    ``window`` estimates. The model is stateless, so the state holds the estimates that u needs. ``mean[:4]`` is
    ``cx, cy, w, h``; up to ``window`` rows ``age, cx, cy, w, h`` of earlier estimates follow, the latest first. The
    covariance is that of the first four, shape (4, 4).

    Args:
        noise: measurement noise.
        window: number of displacements of the mean.
        process: standard deviation of the process noise per frame, as a share of the size.
    """

    name = "paper"

    def __init__(self, noise: MeasurementNoise, window: int = 5, process: float = 0.08) -> None:
        self._noise = noise
        self._window = window
        self._process = process

    def initiate(self, measurement: FloatArray, width: int, height: int) -> MotionState:
        """The state after the first measurement; the picture's size is not used."""
        z = np.asarray(measurement, dtype=np.float64)
        return MotionState(z.copy(), self._noise.covariance(z[2], z[3]))

    def predict(
        self, state: MotionState, dt: float, shift: tuple[float, float], focus_y: float | None = None
    ) -> MotionState:
        """``x + B u``: the last estimate moved by the mean displacement, and by the camera shift."""
        now = state.mean[:4]
        past = state.mean[4:].reshape(-1, 5)
        velocity = (now - past[-1, 1:]) / past[-1, 0] if len(past) and past[-1, 0] > 0 else np.zeros(4)
        # The camera shift also moves earlier estimates, so that u does not count the rotation a second time.
        camera = np.array([shift[0], shift[1], 0.0, 0.0])
        past = np.vstack([np.concatenate([[0.0], now]), past])[: self._window]
        past = past + np.concatenate([[dt], camera])
        ahead = now + velocity * dt + camera
        ahead[2:] = np.maximum(ahead[2:], 1.0)
        std = self._process * np.array([now[2], now[3], now[2], now[3]])
        return MotionState(np.concatenate([ahead, past.ravel()]), state.covariance + np.diag(std**2) * dt)

    def update(
        self, state: MotionState, measurement: FloatArray, quality: MeasurementQuality = FULL_QUALITY
    ) -> MotionState:
        """Standard Kalman update of ``cx, cy, w, h``; the earlier estimates stay."""
        x, P = state.mean[:4], state.covariance
        R = self._noise.covariance(x[2], x[3], quality)
        K, P = update_covariance(P, np.eye(4), R)
        x = x + product(K, (np.asarray(measurement, dtype=np.float64) - x)[:, None])[:, 0]
        x[2:] = np.maximum(x[2:], 1.0)
        return MotionState(np.concatenate([x, state.mean[4:]]), P)

    def box_of(self, state: MotionState) -> FloatArray:
        """``cx, cy, w, h``, shape (4,)."""
        return state.mean[:4].copy()

    def innovation(self, state: MotionState) -> FloatArray:
        """``P + R``, shape (4, 4), px^2."""
        return np.asarray(state.covariance + self._noise.covariance(state.mean[2], state.mean[3]))
