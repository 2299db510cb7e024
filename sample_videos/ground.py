"""The ground: asphalt, markings, kerbs, verge and fields, shaded at the intersections of camera rays with a plane."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.camera import Camera
from sample_videos.colour import Linear, lin
from sample_videos.noise import fractal, sample
from sample_videos.road_path import RoadPath
from sample_videos.weather import Weather

Plane = NDArray[np.floating]
_REACH, _TABLE_STEP, _ROWS = 900.0, 0.25, 24


@dataclass(frozen=True)
class RoadStyle:
    """Cross-section of the road; distances from the centre line in metres.

    Attributes:
        half: Half width of the asphalt.
        edge: Distance of the solid edge lines, 0 for none.
        kerb: Whether a kerb and a pavement follow the asphalt.
        pavement: Outer edge of the pavement.
        dash: Length and period of the centre dashes.
    """

    half: float
    edge: float
    kerb: bool
    pavement: float
    dash: tuple[float, float]


COUNTRY = RoadStyle(half=3.75, edge=3.35, kerb=False, pavement=0.0, dash=(4.0, 12.0))
TOWN = RoadStyle(half=3.6, edge=0.0, kerb=True, pavement=6.0, dash=(3.0, 9.0))


def _planes(r: int, g: int, b: int) -> Linear:
    """A colour as three planes of one value each, to broadcast over a picture (planes are faster than pixels)."""
    return lin(r, g, b).reshape(3, 1, 1)


_ASPHALT, _PAINT, _EARTH = _planes(100, 100, 102), _planes(214, 214, 208), _planes(128, 118, 98)


def _band(distance: Plane, half: float, footprint: Plane) -> Plane:
    """Coverage of a band around distance 0, averaged over a footprint."""
    low = np.maximum(-half, distance - footprint / 2)
    high = np.minimum(half, distance + footprint / 2)
    return np.asarray(np.clip((high - low) / footprint, 0, 1))


class Ground:
    """Shades the ground.

    Args:
        rng: Source of the textures.
        path: Centre line.
        style: Cross-section of the road.
        weather: Light and air.
    """

    def __init__(self, rng: np.random.Generator, path: RoadPath, style: RoadStyle, weather: Weather) -> None:
        self._path, self._style, self._weather = path, style, weather
        self._fine = fractal(rng, 512, 0.15, 6)
        self._middle = fractal(rng, 512, 0.9, 2)
        self._coarse = fractal(rng, 512, 1.5, 1)
        at = np.arange(-12, 12, 0.02)
        profile = np.ones_like(at)
        spread = float(rng.uniform(0.68, 0.86))
        for lane in (-1.75, 1.75):
            for wheel in (-spread, spread):
                profile -= 0.08 * np.exp(-(((at - lane - wheel) / 0.33) ** 2))
            profile += 0.04 * np.exp(-(((at - lane) / 0.3) ** 2))
        self._profile = profile.astype(np.float32)
        self._dirt = np.exp(-(((np.arange(0, 12, 0.02) - style.half - 0.15) / 0.28) ** 2)).astype(np.float32)
        colours = [(176, 156, 92), (96, 112, 48), (122, 100, 72), (84, 108, 42), (150, 142, 82), (112, 124, 56)]
        picks = rng.integers(0, len(colours), (2, 64))
        self._fields = np.moveaxis(
            np.array([[lin(*colours[k]) for k in row] for row in picks], np.float32), 2, 0
        ).copy()
        low, high = (5, -2.6, 2, 0.5), (path.length, 2.2, 7, 1.2)
        self._patches = rng.uniform(low, high, (int(path.length / 22), 4)).tolist()

    def shade(
        self,
        camera: Camera,
        s0: float,
        speed: float,
        sun: Plane,
        sky_light: Plane | None,
        haze: Plane,
        bridge: tuple[float, float] | None,
    ) -> tuple[int, Plane]:
        """Radiance of the ground below the horizon.

        Args:
            camera: The camera.
            s0: Arc length of the car.
            speed: The car's speed, metres per second, for blur along the road.
            sun: (height, width) share of the sun that reaches the ground.
            sky_light: (height, width) radiance added by lamps, or None.
            haze: (b, g, r) radiance of the air.
            bridge: Arc lengths between which a bridge blocks the sky's light, or None.

        Returns:
            First row, and the (rows, width, 3) linear radiance from there to the picture's lower border.
        """
        cx, cy = camera.centre
        horizon = cy + camera.focal * float(
            camera.axes[2, 1] / max(camera.axes[2, 0] ** 2 + camera.axes[2, 2] ** 2, 1e-6) ** 0.5
        )
        top = int(np.clip(horizon - 2 - abs(camera.axes[0, 1]) * cx * 1.1, 0, camera.height - 2))
        seen = self._path.seen_from(s0, _REACH, _TABLE_STEP)
        out = np.empty((camera.height - top, camera.width, 3), np.float32)
        for first in range(top, camera.height, _ROWS):
            last = min(first + _ROWS, camera.height)
            lamps = None if sky_light is None else sky_light[first:last]
            out[first - top : last - top] = self._rows(
                camera, (first, last), s0, speed, seen, sun[first:last], lamps, haze, bridge
            )
        return top, out

    def _rows(
        self,
        camera: Camera,
        span: tuple[int, int],
        s0: float,
        speed: float,
        seen: tuple[NDArray[np.float64], Plane],
        sun: Plane,
        sky_light: Plane | None,
        haze: Plane,
        bridge: tuple[float, float] | None,
    ) -> Plane:
        """Radiance of some rows; few at a time, so that they stay in the cache."""
        dx, dy, dz = camera.rays(*span)
        t = np.float32(camera.position[1]) / np.maximum(-dy, np.float32(1e-5))
        np.minimum(t, np.float32(4000), out=t)
        origin, table = seen
        right, forward = (v.astype(np.float32) for v in self._path.frame(s0))
        px, pz = np.float32(camera.position[0] - origin[0]), np.float32(camera.position[2] - origin[2])
        gx, gz = px + t * dx, pz + t * dz
        ahead = gx * forward[0] + gz * forward[2]
        aside = gx * right[0] + gz * right[2]
        index = np.clip((ahead + 20) / np.float32(_TABLE_STEP), 0, len(table) - 1).astype(np.float32)
        looked = cv2.remap(
            table.reshape(-1, 1, 4).transpose(1, 0, 2).copy(), index, np.zeros_like(index), cv2.INTER_LINEAR
        )
        across = aside - looked[..., 0]
        d = across * looked[..., 2]
        s = ahead + looked[..., 3] + across * looked[..., 1]
        lateral = np.maximum(t / np.float32(camera.focal), np.float32(1e-3))
        along = t * t / np.float32(camera.focal * camera.position[1]) + np.float32(speed * self._weather.shutter)
        albedo, gloss = self._albedo(s0, s, d, lateral, along)
        w = self._weather
        sky = np.ones_like(t)
        if bridge is not None:
            inside = np.clip((s - np.float32(bridge[0] - 3)) / 6, 0, 1) * np.clip(
                (np.float32(bridge[1] + 3) - s) / 6, 0, 1
            )
            sky = 1 - np.float32(0.86) * inside
        light = w.sun.reshape(3, 1, 1) * (sun[None] * np.float32(w.to_sun[1])) + w.ambient.reshape(3, 1, 1) * sky[None]
        out = albedo * light
        if w.sun.max() > 0.3:
            out += (gloss * self._sheen(dx, dy, dz) * sun)[None] * w.sun.reshape(3, 1, 1)
        out += ((gloss * np.float32(0.35)) * sky * (1 - np.clip(-dy * 4, 0, 1)) ** 2)[None] * (
            w.horizon * np.float32(0.25)
        ).reshape(3, 1, 1)
        if sky_light is not None:
            out += albedo * sky_light[None] * np.array([0.75, 0.92, 1.0], np.float32).reshape(3, 1, 1)
        distance = t * np.sqrt(dx * dx + dy * dy + dz * dz)
        air = haze.reshape(3, 1, 1)
        out -= air
        out *= np.exp(-distance / np.float32(w.visibility))[None]
        out += air
        return np.asarray(cv2.merge(list(out)), np.float32)

    def _sheen(self, dx: Plane, dy: Plane, dz: Plane) -> Plane:
        """Reflection of a low sun on rough asphalt."""
        sun = self._weather.to_sun.astype(np.float32)
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        hx, hy, hz = sun[0] - dx / length, sun[1] - dy / length, sun[2] - dz / length
        cosine = hy / np.sqrt(hx * hx + hy * hy + hz * hz)
        grazing = (1 - np.clip(-dy / length, 0, 1)) ** 5
        return np.asarray(np.clip(cosine, 0, 1) ** 60 * grazing * np.float32(0.55))

    def _albedo(self, s0: float, s: Plane, d: Plane, lateral: Plane, along: Plane) -> tuple[NDArray[np.float32], Plane]:
        """Colour of the ground, and how much it mirrors."""
        style = self._style
        side = np.abs(d)
        area = np.sqrt(along * lateral)
        fine = sample(self._fine, d, s, 5.0) * np.clip(1.5 - area / 0.035, 0, 1)
        middle = sample(self._middle, d, s, 37.0) * np.clip(1.6 - area / 0.30, 0, 1)
        coarse = sample(self._coarse, d, s * np.float32(0.5), 210.0)
        column = np.clip((d + 12) * np.float32(50), 0, len(self._profile) - 1).astype(np.int32)
        # asphalt: stones, tracks worn by wheels, patches of repair, cracks
        tone = self._profile[column] + 0.17 * fine + 0.09 * middle + 0.07 * coarse
        for at, where, long, wide in self._patches:
            if s0 - 8 < at < s0 + 90:
                tone -= (
                    0.16 * _band(s - np.float32(at), long / 2, along) * _band(d - np.float32(where), wide / 2, lateral)
                )
        tone -= (
            0.22 * np.clip(1.2 - np.abs(coarse * 1.7 + middle * 0.22) / 0.014, 0, 1) * np.clip(1.4 - along / 0.8, 0, 1)
        )
        gloss = 0.8 + 0.15 * fine
        period = np.float32(style.dash[1])
        far = np.clip(along / period, 0, 1)
        dash = (
            _band(np.mod(s, period) - period / 2, style.dash[0] / 2, np.minimum(along, period)) * (1 - far)
            + far * style.dash[0] / style.dash[1]
        )
        paint = _band(d, 0.07, lateral) * dash
        if style.edge:
            paint = np.maximum(paint, _band(side - style.edge, 0.075, lateral))
        paint *= np.clip(0.86 + 0.10 * fine + 0.12 * middle, 0.35, 1)
        road = (tone * (1 - paint))[None] * _ASPHALT + paint[None] * _PAINT
        beyond = self._verge(s, d, side, fine, middle, coarse, along)
        if style.kerb:
            road = self._pavement(road, s, d, side, fine, middle, lateral, along)
            outer, soft = np.float32(style.pavement), 0.12 + 2 * lateral
        else:
            outer, soft = np.float32(style.half), 0.16 + 1.5 * lateral
            dirt = self._dirt[np.clip(side * 50, 0, len(self._dirt) - 1).astype(np.int32)] * np.clip(
                0.6 + 0.3 * middle, 0, 1
            )
            beyond += (dirt * (1 + 0.25 * fine))[None] * _EARTH - beyond * dirt[None]
        green = np.clip((side - outer + 0.09 * middle + 0.05 * fine) / soft + 0.5, 0, 1)
        road += (beyond - road) * green[None]
        return np.asarray(np.maximum(road, np.float32(0.004))), np.asarray(gloss * (1 - green))

    def _pavement(
        self,
        albedo: NDArray[np.float32],
        s: Plane,
        d: Plane,
        side: Plane,
        fine: Plane,
        middle: Plane,
        lateral: Plane,
        along: Plane,
    ) -> NDArray[np.float32]:
        """Kerb stones, a gutter and concrete slabs."""
        style = self._style
        slab = _planes(150, 146, 139) * (1 + 0.10 * fine + 0.06 * middle)[None]
        joint = np.maximum(
            _band(np.mod(s, 0.5) - 0.25, 0.012, np.maximum(along, 0.012)) * np.clip(1.5 - along / 0.25, 0, 1),
            _band(np.mod(side, 0.5) - 0.25, 0.012, np.maximum(lateral, 0.012)) * np.clip(1.5 - lateral / 0.25, 0, 1),
        )
        slab = slab * (1 - 0.45 * joint[None])
        kerb = _planes(168, 164, 158) * (1 + 0.08 * fine)[None]
        gap = _band(np.mod(s, 1.0) - 0.5, 0.02, np.maximum(along, 0.02)) * np.clip(1.5 - along / 0.5, 0, 1)
        kerb = kerb * (1 - 0.4 * gap[None])
        face = _band(side - style.half - 0.03, 0.05, lateral)[None]
        gutter = _band(side - style.half + 0.14, 0.14, lateral)[None]
        on_slab = np.clip((side - style.half - 0.15) / lateral + 0.5, 0, 1)[None]
        on_kerb = np.clip((side - style.half) / lateral + 0.5, 0, 1)[None]
        albedo = albedo * (1 - 0.25 * gutter)
        albedo = albedo * (1 - on_kerb) + kerb * on_kerb
        albedo = albedo * (1 - 0.55 * face)
        return np.asarray(albedo * (1 - on_slab) + slab * on_slab, np.float32)

    def _verge(
        self, s: Plane, d: Plane, side: Plane, fine: Plane, middle: Plane, coarse: Plane, along: Plane
    ) -> NDArray[np.float32]:
        """Grass beside the road, fields beyond."""
        variation = 1 + 0.26 * fine + 0.20 * middle + 0.10 * coarse
        grass = _planes(84, 94, 54) * variation[None]
        dry = np.clip(0.25 + 0.3 * coarse + 0.2 * middle, 0, 1)[None]
        grass = grass * (1 - 0.55 * dry) + _planes(128, 120, 76) * variation[None] * 0.55 * dry
        if self._style.kerb:
            return np.asarray(grass, np.float32)
        number = np.clip(np.floor((s + side * 0.35 + 400) / 95), 0, 63).astype(np.int32)
        field = self._fields[:, (d > 0).astype(np.int32), number]
        rows_seen = np.clip(1.5 - along / 1.2, 0, 1)
        rows = (
            1
            + 0.16 * np.sin(d * np.float32(2 * np.pi / 1.4) + 0.8 * middle) * rows_seen
            + 0.18 * middle
            + 0.12 * fine
            + 0.16 * coarse
        )
        field = field * rows[None]
        beyond = np.clip((side - 11.5 - 1.0 * coarse) / 1.5 + 0.5, 0, 1)[None]
        ditch = np.exp(-(((side - 8.2) / 0.9) ** 2))[None]
        grass = grass * (1 - 0.42 * ditch)
        return np.asarray(grass * (1 - beyond) + field * beyond, np.float32)
