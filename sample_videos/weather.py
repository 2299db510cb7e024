"""Light and air: the sun's position, the light of sun and sky, haze, and the exposure time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sample_videos.colour import Linear

Array = NDArray[np.float64]


def _bgr(r: float, g: float, b: float) -> Linear:
    return np.array([b, g, r], np.float32)


@dataclass(frozen=True)
class Weather:
    """One state of light and air. Colours are linear (b, g, r); a white wall in full sun is about 2 to 3.

    Attributes:
        name: Name of the state.
        sun_azimuth: Degrees to the right of the road's first heading.
        sun_elevation: Degrees above the horizon.
        sun: Light of the sun on a surface that faces it.
        ambient: Light of the sky on a surface that faces up.
        zenith: Radiance of the sky overhead.
        horizon: Radiance of the sky at the horizon, and of haze.
        glow: Radiance added around the sun.
        visibility: Distance at which haze absorbs 63 percent, metres.
        cover: Share of the sky under clouds, 0 to 1.
        shutter: Exposure time, seconds.
        noise: Standard deviation of the sensor noise at middle grey, of 255.
        lamps: Whether lamps and lit windows are on.
        key: Target mean level of the exposure, linear.
    """

    name: str
    sun_azimuth: float
    sun_elevation: float
    sun: Linear
    ambient: Linear
    zenith: Linear
    horizon: Linear
    glow: Linear
    visibility: float
    cover: float
    shutter: float
    noise: float
    lamps: bool
    key: float

    @property
    def to_sun(self) -> Array:
        """Unit vector towards the sun in the world."""
        a, e = np.radians(self.sun_azimuth), np.radians(self.sun_elevation)
        return np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])

    def shade(self, normal: Array, lit: float = 1.0) -> Linear:
        """Light on a surface with a normal; `lit` is the share of the sun that reaches it."""
        direct = max(0.0, float(normal @ self.to_sun)) * lit
        sky = 0.55 + 0.45 * float(normal[1])
        return np.asarray(self.sun * direct + self.ambient * sky, np.float32)

    def haze(self, distance: float) -> float:
        """Share of an object's light that passes the air over a distance in metres."""
        return float(np.exp(-distance / self.visibility))


WEATHERS: dict[str, Weather] = {
    w.name: w
    for w in (
        Weather(
            "day",
            -128,
            41,
            _bgr(2.5, 2.3, 1.95),
            _bgr(0.62, 0.74, 0.92),
            _bgr(0.25, 0.52, 1.15),
            _bgr(1.25, 1.45, 1.65),
            _bgr(1.2, 1.1, 0.9),
            2300,
            0.48,
            1 / 500,
            1.6,
            False,
            0.20,
        ),
        Weather(
            "low_sun",
            9,
            9,
            _bgr(3.4, 2.35, 1.15),
            _bgr(0.50, 0.52, 0.58),
            _bgr(0.30, 0.48, 0.88),
            _bgr(2.3, 1.75, 1.2),
            _bgr(7.0, 4.2, 1.9),
            900,
            0.30,
            1 / 250,
            2.4,
            False,
            0.17,
        ),
        Weather(
            "overcast",
            40,
            50,
            _bgr(0.25, 0.25, 0.25),
            _bgr(1.15, 1.2, 1.25),
            _bgr(1.2, 1.25, 1.32),
            _bgr(1.45, 1.5, 1.55),
            _bgr(0.3, 0.3, 0.3),
            1100,
            0.97,
            1 / 200,
            2.4,
            False,
            0.20,
        ),
        Weather(
            "dusk",
            -62,
            2,
            _bgr(0.10, 0.06, 0.04),
            _bgr(0.17, 0.20, 0.30),
            _bgr(0.07, 0.11, 0.26),
            _bgr(0.62, 0.42, 0.34),
            _bgr(0.5, 0.25, 0.1),
            1500,
            0.45,
            1 / 60,
            4.6,
            True,
            0.06,
        ),
    )
}
"""The states of light and air by name."""
