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

    def haze(self, distance: float) -> float:
        """Share of an object's light that passes the air over a distance in metres."""
        return float(np.exp(-distance / self.visibility))


WEATHERS: dict[str, Weather] = {
    w.name: w
    for w in (
        Weather(
            "day", sun_azimuth=-128, sun_elevation=41, visibility=2300, cover=0.48, shutter=1 / 500, noise=1.6,
            lamps=False, key=0.20, sun=_bgr(2.5, 2.3, 1.95), ambient=_bgr(0.62, 0.74, 0.92),
            zenith=_bgr(0.25, 0.52, 1.15), horizon=_bgr(1.25, 1.45, 1.65), glow=_bgr(1.2, 1.1, 0.9),
        ),
        Weather(
            "low_sun", sun_azimuth=9, sun_elevation=9, visibility=900, cover=0.30, shutter=1 / 250, noise=2.4,
            lamps=False, key=0.17, sun=_bgr(3.4, 2.35, 1.15), ambient=_bgr(0.50, 0.52, 0.58),
            zenith=_bgr(0.30, 0.48, 0.88), horizon=_bgr(2.3, 1.75, 1.2), glow=_bgr(7.0, 4.2, 1.9),
        ),
        Weather(
            "overcast", sun_azimuth=40, sun_elevation=50, visibility=1100, cover=0.97, shutter=1 / 200, noise=2.4,
            lamps=False, key=0.20, sun=_bgr(0.25, 0.25, 0.25), ambient=_bgr(1.15, 1.2, 1.25),
            zenith=_bgr(1.2, 1.25, 1.32), horizon=_bgr(1.45, 1.5, 1.55), glow=_bgr(0.3, 0.3, 0.3),
        ),
        Weather(
            "dusk", sun_azimuth=-62, sun_elevation=2, visibility=1500, cover=0.45, shutter=1 / 60, noise=4.6,
            lamps=True, key=0.06, sun=_bgr(0.10, 0.06, 0.04), ambient=_bgr(0.17, 0.20, 0.30),
            zenith=_bgr(0.07, 0.11, 0.26), horizon=_bgr(0.62, 0.42, 0.34), glow=_bgr(0.5, 0.25, 0.1),
        ),
    )
}  # fmt: skip
"""The states of light and air by name."""
