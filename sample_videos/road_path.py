"""The centre line of the road: a smooth curve on the ground, measured by arc length."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STEP = 0.5
"""Spacing of the stored centre line, metres."""


class RoadPath:
    """A road's centre line with given bends.

    Args:
        length: Length, metres; it begins 60 m before s = 0.
        bends: (start, end, turn) of each bend: arc lengths in metres, total turn in radians, positive to the right.
    """

    BEHIND = 60.0

    def __init__(self, length: float, bends: list[tuple[float, float, float]]) -> None:
        self.length = length
        s = np.arange(-self.BEHIND, length + STEP, STEP)
        curvature = np.zeros_like(s)
        for start, end, turn in bends:
            x = np.clip((s - start) / (end - start), 0, 1)
            curvature += turn * (1 - np.cos(2 * np.pi * x)) / (end - start)
        heading = np.cumsum(curvature) * STEP
        heading -= np.interp(0.0, s, heading)
        self._s, self._heading = s, heading
        self._x = np.cumsum(np.sin(heading)) * STEP
        self._z = np.cumsum(np.cos(heading)) * STEP
        self._x -= np.interp(0.0, s, self._x)
        self._z -= np.interp(0.0, s, self._z)

    @classmethod
    def winding(cls, length: float, turn: float, rng: np.random.Generator) -> RoadPath:
        """A road with long bends, alternately to the right and to the left, of about ``turn`` radians each."""
        bends: list[tuple[float, float, float]] = []
        s, sign = 25.0, 1.0
        while s < length - 50:
            run = float(rng.uniform(110, 190))
            bends.append((s, s + run, sign * turn * float(rng.uniform(0.7, 1.3))))
            s += run + float(rng.uniform(10, 50))
            sign = -sign
        return cls(length, bends)

    def heading(self, s: float) -> float:
        """Heading at an arc length, radians, positive to the right of +Z."""
        return float(np.interp(s, self._s, self._heading))

    def point(self, s: float, d: float, y: float = 0.0) -> Array:
        """World point `d` metres to the right of the centre line at `s`, `y` metres up."""
        h = self.heading(s)
        x = float(np.interp(s, self._s, self._x)) + d * np.cos(h)
        z = float(np.interp(s, self._s, self._z)) - d * np.sin(h)
        return np.array([x, y, z])

    def frame(self, s: float) -> tuple[Array, Array]:
        """Unit vectors (right, forward) of the road at an arc length."""
        h = self.heading(s)
        return np.array([np.cos(h), 0.0, -np.sin(h)]), np.array([np.sin(h), 0.0, np.cos(h)])

    def seen_from(self, s0: float, reach: float, step: float) -> tuple[Array, NDArray[np.float32]]:
        """The centre line ahead in the frame of the road at `s0`.

        Args:
            s0: Arc length of the frame.
            reach: Length ahead, metres; beyond it the line is straight.
            step: Spacing of the table in forward distance, metres.

        Returns:
            The frame's origin in the world, and a (n, 4) table over forward distance from -20 m on: lateral position,
            sine and cosine of the heading relative to the frame, arc length minus forward distance.
        """
        right, forward = self.frame(s0)
        origin = self.point(s0, 0.0)
        keep = (self._s > s0 - 30) & (self._s < s0 + reach + 30)
        offset = np.stack([self._x[keep] - origin[0], np.zeros(keep.sum()), self._z[keep] - origin[2]], axis=1)
        ahead, aside = offset @ forward, offset @ right
        at = np.arange(-20.0, reach, step)
        order = np.argsort(ahead)
        ahead, aside = ahead[order], aside[order]
        turn = self._heading[keep][order] - self.heading(s0)
        angle = np.interp(at, ahead, turn)
        table = [
            np.interp(at, ahead, aside),
            np.sin(angle),
            np.cos(angle),
            np.interp(at, ahead, self._s[keep][order]) - at,
        ]
        return origin, np.stack(table, axis=1).astype(np.float32)
