"""Converts linear light to the picture of a dash camera: exposure, bloom, flare, shake blur, tone curve, noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.camera import Camera
from sample_videos.linear_canvas import motion_blur_kernel
from sample_videos.noise import fractal
from sample_videos.weather import Weather

Plane = NDArray[np.float32]
_STEPS, _ROWS = 4096, 24
_DULL = (np.eye(3) * 0.92 + 0.08 / 3).astype(np.float32)
"""A little grey mixed into each colour."""


def _curve() -> Plane:
    """Film-like tone curve over square-rooted linear light from 0 to 16, as sRGB from 0 to 255."""
    x = (np.arange(_STEPS) / (_STEPS - 1) * 4) ** 2 * 1.15
    y = np.clip(x * (2.35 * x + 0.06) / (x * (2.25 * x + 0.72) + 0.14), 0, 1)
    return (255 * np.clip(y, 0, 1) ** (1 / 2.15)).astype(np.float32)


class Lens:
    """The camera's optics and sensor; the exposure follows the scene.

    Args:
        rng: Source of noise.
        weather: Light and air.
        width: Picture width.
        height: Picture height.
    """

    def __init__(self, rng: np.random.Generator, weather: Weather, width: int, height: int) -> None:
        self._weather = weather
        self._curve = _curve()
        self._exposure: float | None = None
        self._grain = [self._grains(rng, width, height) for _ in range(2)]
        y, x = np.mgrid[0:height, 0:width].astype(np.float32)
        r2 = ((x - width / 2) ** 2 + (y - height / 2) ** 2) / (width / 2) ** 2
        self._vignette = (1 / (1 + 0.16 * r2) ** 2).astype(np.float32)[..., None]
        self._bonnet = self._hood(width, height)
        self._dust = self._smears(rng, width, height)

    def _grains(self, rng: np.random.Generator, width: int, height: int) -> Plane:
        """Noise larger than the picture, of which random parts are used."""
        tile = np.dstack([0.75 * rng.standard_normal((512, 512)) + 0.5 * fractal(rng, 512, 0.25, 40) for _ in range(3)])
        return np.tile(tile.astype(np.float32), (height // 512 + 2, width // 512 + 2, 1))

    def _hood(self, width: int, height: int) -> Plane:
        """Coverage of the car's bonnet at the lower border."""
        x = (np.arange(width) + 0.5) / width * 2 - 1
        edge = height * (0.955 + 0.055 * np.abs(x - 0.08) ** 2.2)
        rows = np.arange(height)[:, None]
        soft = height / 140
        return np.clip((rows - edge[None]) / soft + 0.5, 0, 1).astype(np.float32)

    def _smears(self, rng: np.random.Generator, width: int, height: int) -> Plane:
        """Dust on the windscreen that scatters sunlight."""
        tile = cv2.resize(fractal(rng, 256, 0.8, 2), (width, height), interpolation=cv2.INTER_CUBIC)
        return np.asarray(np.clip(0.5 + 0.35 * tile, 0, 1.6), np.float32)[..., None]

    def bonnet(self, image: NDArray[np.float32]) -> None:
        """Paint the car's bonnet, which mirrors the sky."""
        rows = np.flatnonzero(self._bonnet.max(1) > 0)
        if len(rows) == 0:
            return
        top = int(rows[0])
        cover = self._bonnet[top:, :, None]
        w = self._weather
        h = image.shape[0]
        mirror = np.linspace(1, 0.35, h - top, dtype=np.float32)[:, None, None]
        colour = w.horizon * np.float32(0.085) * mirror + w.ambient * np.float32(0.02)
        image[top:] = image[top:] * (1 - cover) + colour * cover

    def expose(
        self,
        image: NDArray[np.float32],
        camera: Camera,
        dt: float,
        rotation: tuple[float, float],
        sun_seen: float,
        rng: np.random.Generator,
    ) -> NDArray[np.uint8]:
        """Record a linear picture.

        Args:
            image: (height, width, 3) linear radiance.
            camera: The camera.
            dt: Time since the previous picture, seconds.
            rotation: Motion of the picture by shaking, pixels per second (right, down).
            sun_seen: Share of the sun that reaches the lens, 0 to 1.
            rng: Source of this picture's noise.

        Returns:
            (height, width, 3) BGR uint8.
        """
        w = self._weather
        height, width = image.shape[:2]
        kernel = motion_blur_kernel(rotation[0] * w.shutter, rotation[1] * w.shutter)
        if kernel is not None:
            image = cv2.filter2D(image, -1, kernel, borderType=cv2.BORDER_REPLICATE)
        small = cv2.resize(image, (width // 8, height // 8), interpolation=cv2.INTER_AREA)
        metered = small[int(small.shape[0] * 0.25) :]
        mean = float(np.exp(np.log(np.maximum(metered.mean(2), 1e-3)).mean()))
        wanted = w.key / mean
        if self._exposure is None:
            self._exposure = wanted
        pace = 1 - np.exp(-dt / (0.35 if wanted < self._exposure else 0.8))
        self._exposure = float(np.exp(np.log(self._exposure) + pace * (np.log(wanted) - np.log(self._exposure))))
        bright = np.clip(small * np.float32(self._exposure) - 0.9, 0, 12)
        bloom = np.zeros_like(small)
        for sigma, weight in ((1.5, 0.05), (6.0, 0.035), (24.0, 0.03)):
            bloom += np.float32(weight) * cv2.GaussianBlur(bright, (0, 0), sigma * width / 1280)
        out = image * np.float32(self._exposure) + cv2.resize(bloom, (width, height), interpolation=cv2.INTER_LINEAR)
        if sun_seen > 0:
            self._flare(out, camera, sun_seen)
        x, y = (int(v) for v in rng.integers(0, 512, 2))
        grain = self._grain[int(rng.integers(2))][y : y + height, x : x + width]
        picture = np.empty((height, width, 3), np.uint8)
        for first in range(0, height, _ROWS):
            rows = slice(first, min(first + _ROWS, height))
            picture[rows] = self._develop(out[rows] * self._vignette[rows], grain[rows])
        return picture

    def _develop(self, light: NDArray[np.float32], grain: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Apply tone curve and grain to exposed light."""
        mixed = cv2.transform(light, _DULL)
        index = np.sqrt(np.clip(mixed, 0, 16)) * np.float32((_STEPS - 1) / 4)
        picture = self._curve[index.astype(np.int32)]
        level = (np.float32(1.25) - picture * np.float32(1 / 290)) * np.float32(self._weather.noise)
        return np.asarray(np.clip(picture + grain * level + np.float32(0.5), 0, 255), np.uint8)

    def _flare(self, out: NDArray[np.float32], camera: Camera, seen: float) -> None:
        """Veiling glare, streaks and ghosts of a sun near the picture."""
        w = self._weather
        local = camera.axes @ w.to_sun
        if local[2] <= 0.2 or w.sun.max() < 0.3:
            return
        height, width = out.shape[:2]
        cx, cy = camera.centre
        sx, sy = local[0] / local[2] * camera.focal + cx, local[1] / local[2] * camera.focal + cy
        if not (-0.4 * width < sx < 1.4 * width and -0.6 * height < sy < 1.3 * height):
            return
        h, wd = height // 4, width // 4
        y, x = np.mgrid[0:h, 0:wd].astype(np.float32)
        dx, dy = (x * 4 - np.float32(sx)) / width, (y * 4 - np.float32(sy)) / width
        r = np.sqrt(dx * dx + dy * dy) + np.float32(1e-4)
        angle = np.arctan2(dy, dx)
        rays = 0.5 + 0.5 * np.cos(angle * 9 + 1.3) ** 8 + 0.4 * np.cos(angle * 23) ** 6
        veil = 0.14 * np.exp(-r * 5.5) + 0.70 * np.exp(-r * 24) + 0.05 * rays * np.exp(-r * 9)
        layer = veil[..., None] * np.array([0.55, 0.82, 1.0], np.float32)
        for along, radius, strength, tint in (
            (0.62, 0.045, 0.035, (0.9, 0.7, 0.3)),
            (1.35, 0.075, 0.022, (0.3, 0.9, 0.4)),
            (1.7, 0.03, 0.04, (0.3, 0.5, 0.9)),
        ):
            gx, gy = sx + (cx - sx) * along, sy + (height / 2 - sy) * along
            rr = np.sqrt((x * 4 - np.float32(gx)) ** 2 + (y * 4 - np.float32(gy)) ** 2) / width
            ghost = np.float32(strength) * np.clip((radius - rr) / 0.006, 0, 1)
            layer += ghost[..., None] * np.array(tint, np.float32)
        power = np.float32(seen * min(1.0, float(w.sun.max()) / 3))
        veil_full = cv2.resize(layer, (width, height), interpolation=cv2.INTER_LINEAR)
        out += veil_full * power * (0.72 + 0.4 * self._dust)
