"""Sky, clouds, sun and the hills on the horizon."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.camera import Camera
from sample_videos.colour import Linear, lin
from sample_videos.noise import fractal, sample
from sample_videos.weather import Weather

Plane = NDArray[np.float32]
_PANORAMA = (256, 4096)
_LOW, _HIGH = np.radians(-0.6), np.radians(7.0)


def _unit(dx: Plane, dy: Plane, dz: Plane) -> tuple[Plane, Plane, Plane]:
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    return dx / length, dy / length, dz / length


class Sky:
    """Paints everything at infinity.

    Args:
        rng: Source of clouds and hills.
        weather: Light and air.
        hills: Height of the hills; 1 is a hilly country.
    """

    def __init__(self, rng: np.random.Generator, weather: Weather, hills: float) -> None:
        self._weather = weather
        self._clouds = fractal(rng, 1024, 1.62, 2, 300)
        self._wisps = fractal(rng, 512, 1.2, 2)
        self._panorama = self._hills(rng, hills)

    def haze(self, camera: Camera) -> Linear:
        """Radiance of the air in the middle of the view."""
        forward = camera.axes[2]
        w = self._weather
        near_sun = max(float(forward @ w.to_sun), 0.0)
        return np.asarray(w.horizon * 0.78 + w.glow * np.float32(0.16 * near_sun**6), np.float32)

    def _hills(self, rng: np.random.Generator, height: float) -> NDArray[np.float32]:
        h, w = _PANORAMA
        out = np.zeros((h, w, 4), np.float32)
        elevation = np.linspace(_HIGH, _LOW, h, dtype=np.float32)[:, None]
        texture = fractal(rng, 1024, 0.8, 4)
        texture = np.tile(cv2.resize(texture, (1024, h)), (1, 4))
        weather = self._weather
        x = np.arange(w) / w * 2 * np.pi
        for distance, rise, colour, rough in (
            (9000.0, 4.8, (80, 98, 78), 0.02),
            (4200.0, 3.2, (80, 98, 62), 0.04),
            (1700.0, 1.9, (66, 84, 46), 0.10),
        ):
            crest = np.full(w, rise * 0.42)
            for k in range(2, 60):
                crest += rise * 0.55 / k**1.25 * np.sin(k * x + rng.uniform(0, 2 * np.pi)) * rng.uniform(0.3, 1)
            jag = sum(np.sin(k * x + rng.uniform(0, 6.28)) for k in rng.integers(250, 1500, 40)) / 6.0
            crest = np.radians(np.maximum(crest, 0.12) * height + rough * np.abs(jag))
            inside = np.clip((crest[None].astype(np.float32) - elevation) / np.float32((_HIGH - _LOW) / h) + 0.5, 0, 1)
            top = int(np.argmax(inside.any(1)))  # the rows above show nothing of these hills
            inside, grain = inside[top:], texture[top:]
            depth = np.clip((crest[None] - elevation[top:]) / np.radians(1.0), 0, 3)
            meadow = np.clip(np.roll(grain, 333, 1) * 1.5 - 0.4, 0, 1)[..., None]
            base = lin(*colour) * (1 - meadow * 0.7) + lin(134, 136, 74) * meadow * 0.7
            base = base * (0.75 + 0.32 * grain + 0.10 * depth)[..., None]
            light = weather.sun * np.float32(0.45 if weather.sun_elevation > 20 else 0.12) + weather.ambient
            air = np.float32(np.exp(-distance / (weather.visibility * 2.6)))
            shaded = base * light * air + weather.horizon * np.float32(0.62) * (1 - air)
            part = out[top:]
            part[..., :3] = part[..., :3] * (1 - inside[..., None]) + np.maximum(shaded, 0) * inside[..., None]
            part[..., 3] = np.maximum(part[..., 3], inside)
        return out

    def paint(self, camera: Camera, image: NDArray[np.float32], bottom: int, t: float) -> None:
        """Paint the rows above `bottom` of a linear picture at a time in seconds."""
        bottom = int(np.clip(bottom, 1, camera.height))
        full = camera.rays(0, bottom)
        w = self._weather
        size = (camera.width // 2, max(bottom // 2, 1))
        dx, dy, dz = _unit(*(cv2.resize(v, size, interpolation=cv2.INTER_AREA) for v in full))
        up = np.clip(dy, 0, 1)
        mix = np.exp(-up * np.float32(5.2))[..., None]
        sky = w.horizon * mix + w.zenith * (1 - mix)
        sun = w.to_sun.astype(np.float32)
        cosine = np.clip(dx * sun[0] + dy * sun[1] + dz * sun[2], 0, 1)
        glow = 0.22 * cosine**8 + 0.45 * cosine**64 + 1.0 * cosine**700
        sky = sky + w.glow * glow[..., None]
        sky = self._cover(sky, dx, dy, dz, cosine, t)
        sky = cv2.resize(sky.astype(np.float32), (camera.width, bottom), interpolation=cv2.INTER_LINEAR)
        self._disc(sky, camera)
        ph, pw = _PANORAMA
        low = (full[1] < np.float32(np.sin(_HIGH) * 1.2)).any(1)
        first = int(np.argmax(low)) if low.any() else bottom
        if first < bottom:
            dx, dy, dz = _unit(*(v[first:] for v in full))
            cosine = np.clip(dx * sun[0] + dy * sun[1] + dz * sun[2], 0, 1)
            column = np.mod((np.arctan2(dx, dz) / np.float32(2 * np.pi) + np.float32(0.5)) * pw, pw)
            row = (np.float32(_HIGH) - np.arcsin(np.clip(dy, -1, 1))) / np.float32(_HIGH - _LOW) * ph
            hills = cv2.remap(
                self._panorama, column, np.clip(row, 0, ph - 1), cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
            )
            hills[row < 0] = 0
            part = hills[..., 3:]
            extra = (w.glow * np.float32(0.25)) * (cosine**24)[..., None]
            sky[first:] = sky[first:] * (1 - part) + hills[..., :3] + extra * part
        image[:bottom] = sky

    def _disc(self, sky: NDArray[np.float32], camera: Camera) -> None:
        """Add the sun's disc."""
        w = self._weather
        local = camera.axes @ w.to_sun
        if local[2] <= 0.1 or w.cover >= 0.9:
            return
        x = local[0] / local[2] * camera.focal + camera.centre[0]
        y = local[1] / local[2] * camera.focal + camera.centre[1]
        rim, core = (camera.focal * np.tan(np.radians(angle)) for angle in (0.55, 0.35))
        x0, y0 = max(int(x - rim - 2), 0), max(int(y - rim - 2), 0)
        part = sky[y0 : max(int(y + rim + 3), 0), x0 : max(int(x + rim + 3), 0)]
        if part.size == 0:
            return
        v, u = np.mgrid[0 : part.shape[0], 0 : part.shape[1]].astype(np.float32)
        radius = np.hypot(u + np.float32(x0 + 0.5 - x), v + np.float32(y0 + 0.5 - y))
        disc = np.clip((np.float32(rim) - radius) / np.float32(rim - core), 0, 1)
        part += (disc * np.float32(60 * min(1.0, float(w.sun.max()) / 2)))[..., None] * w.sun

    def _cover(
        self, sky: NDArray[np.float32], dx: Plane, dy: Plane, dz: Plane, cosine: Plane, t: float
    ) -> NDArray[np.float32]:
        """Clouds on a plane overhead, thinner at their borders and dark below."""
        w = self._weather
        if w.cover <= 0:
            return sky
        height = np.maximum(dy, np.float32(0.012)) + np.float32(0.05)
        u, v = dx / height * 1.2 + np.float32(t * 0.004), dz / height * 1.2
        dense = sample(self._clouds, u, v, 9.0) + 0.30 * sample(self._wisps, u, v, 1.7)
        sun = w.to_sun
        toward = sample(self._clouds, u + np.float32(0.14 * sun[0]), v + np.float32(0.14 * sun[2]), 9.0)
        threshold = np.float32(1.35 - 2.5 * w.cover)
        body = np.clip((dense - threshold) / 1.1, 0, 1)
        alpha = body * body * (3 - 2 * body)
        alpha = alpha * np.clip((dy - 0.008) / 0.05, 0, 1)
        relief = np.clip(0.62 + 0.55 * (dense - toward) - 0.22 * body, 0.12, 1.25)
        if w.cover > 0.9:
            relief = 0.8 + 0.06 * dense
        white = (
            w.sun * np.float32(0.62) + w.ambient * np.float32(0.75) if w.cover < 0.9 else w.ambient * np.float32(1.15)
        )
        cloud = relief[..., None] * white + w.glow * (0.30 * cosine**20)[..., None]
        far = np.exp(-np.clip(dy, 0, 1) * 9)[..., None]
        cloud = cloud * (1 - 0.7 * far) + w.horizon * 0.7 * far
        alpha = alpha[..., None] * np.float32(0.93)
        return np.asarray(sky * (1 - alpha) + cloud * alpha, np.float32)
