"""A pinhole camera on a car, and the shaking of the car.

World: X right, Y up, Z forward, metres. Camera: x right, y down, z forward.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEAR = 0.35
"""Distance of the near plane, metres."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with its pose.

    Attributes:
        width: Picture width, pixels.
        height: Picture height, pixels.
        focal: Focal length, pixels.
        position: (3,) world position, metres.
        axes: (3, 3) rows: the camera's right, down and forward in the world.
    """

    width: int
    height: int
    focal: float
    position: Array
    axes: Array

    @property
    def centre(self) -> tuple[float, float]:
        """Principal point in pixel-edge coordinates; above the middle, because the camera looks slightly down."""
        return self.width / 2, self.height * 0.46

    def to_camera(self, points: Array) -> Array:
        """Convert world points (..., 3) to the camera's frame."""
        return np.asarray((np.asarray(points, np.float64) - self.position) @ self.axes.T)

    def project(self, points: Array) -> Array:
        """Project world points (..., 3) before the camera to picture points (..., 2), pixel-edge coordinates."""
        local = self.to_camera(points)
        depth = np.maximum(local[..., 2:], 1e-6)
        return np.asarray(local[..., :2] / depth * self.focal + np.array(self.centre))

    def rays(self, top: int, bottom: int) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """World directions (X, Y, Z), not normalised, through the pixel centres of rows `top` up to before `bottom`."""
        cx, cy = self.centre
        u = ((np.arange(self.width) + 0.5 - cx) / self.focal).astype(np.float32)[None]
        v = ((np.arange(top, bottom) + 0.5 - cy) / self.focal).astype(np.float32)[:, None]
        right, down, forward = self.axes.astype(np.float32)
        return (
            u * right[0] + v * down[0] + forward[0],
            u * right[1] + v * down[1] + forward[1],
            u * right[2] + v * down[2] + forward[2],
        )


def look(width: int, height: int, focal: float, position: Array, yaw: float, pitch: float, roll: float) -> Camera:
    """A camera at a position.

    Args:
        width: Picture width, pixels.
        height: Picture height, pixels.
        focal: Focal length, pixels.
        position: World position, metres.
        yaw: Heading, radians, positive to the right of +Z.
        pitch: Positive looks up, radians.
        roll: Positive leans the camera to the right, radians.

    Returns:
        The camera.
    """
    sy, cy, sp, cp = np.sin(yaw), np.cos(yaw), np.sin(pitch), np.cos(pitch)
    forward = np.array([sy * cp, sp, cy * cp])
    right = np.array([cy, 0.0, -sy])
    up = np.cross(forward, right)
    leaned = right * np.cos(roll) - up * np.sin(roll)
    down = np.cross(leaned, forward)
    return Camera(width, height, focal, np.asarray(position, np.float64), np.stack([leaned, down, forward]))


class Shake:
    """Pitch, yaw, roll and heave of a car body: oscillations of random phase, and damped jolts at bumps.

    Args:
        rng: Source of phases.
        level: 1 is a good country road.
        bumps: Times (s) and strengths (1 is a pothole) of single jolts.
    """

    def __init__(self, rng: np.random.Generator, level: float, bumps: list[tuple[float, float]]) -> None:
        self._level = level
        self._bumps = bumps
        self._frequency = rng.uniform([0.5, 1.1, 2.6, 7.0], [0.9, 1.9, 4.5, 12.0], (4, 4))
        self._phase = rng.uniform(0, 2 * np.pi, (4, 4))
        self._weight = np.array([1.0, 0.8, 0.35, 0.12])

    def at(self, t: float) -> Array:
        """(pitch, yaw, roll) in radians and heave in metres at a time in seconds."""
        wave = (np.sin(2 * np.pi * self._frequency * t + self._phase) * self._weight).sum(1)
        amounts = np.array([0.0016, 0.0011, 0.0026, 0.006]) * wave * self._level
        for start, strength in self._bumps:
            if t > start:
                after = t - start
                ring = np.exp(-after / 0.28) * np.sin(2 * np.pi * 3.6 * after)
                buzz = np.exp(-after / 0.16) * np.sin(2 * np.pi * 11.0 * after)
                amounts += strength * np.array([0.016 * ring + 0.004 * buzz, 0.004 * buzz, 0.010 * ring, 0.03 * ring])
        return np.asarray(amounts)
