"""Trees, bushes, hedges and grass: pictures made of many small leaves, lit from the sun's direction."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.colour import Linear, lin
from sample_videos.linear_canvas import Patch
from sample_videos.noise import mipmaps
from sample_videos.weather import Weather

Array = NDArray[np.float64]
_SCALE = 3.2
"""Maximum radiance of the 8-bit picture of leaves."""


def _encode(colour: Linear) -> tuple[float, float, float, float]:
    v = np.sqrt(np.clip(colour / _SCALE, 0, 1)) * 255
    return float(v[0]), float(v[1]), float(v[2]), 255.0


def _finish(bgra: NDArray[np.uint8]) -> list[Patch]:
    size = (bgra.shape[1] // 2, bgra.shape[0] // 2)
    picture = bgra.astype(np.float32) / 255
    picture[..., :3] = picture[..., :3] ** 2 * _SCALE * picture[..., 3:]
    return mipmaps(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))


def _sun_in_picture(weather: Weather) -> Array:
    """Direction to the sun as (right, up, towards the viewer)."""
    sun = weather.to_sun
    return np.array([sun[0], sun[1], -sun[2]])


def _leaves(
    rng: np.random.Generator,
    weather: Weather,
    blobs: Array,
    count: int,
    leaf: float,
    colour: tuple[float, float, float],
    bgra: NDArray[np.uint8],
    squash: float = 1.0,
) -> None:
    """Paint leaves on the surface of spheres.

    Args:
        rng: Source of places and tints.
        weather: Light.
        blobs: (n, 4) centres (x, y, z) in pixels, z towards the viewer, and radii.
        count: Number of leaf clusters.
        leaf: Their radius, pixels.
        colour: Mean leaf colour, sRGB.
        bgra: Picture to paint on, with its coverage.
        squash: Ratio of a cluster's height to its width.
    """
    sun = _sun_in_picture(weather)
    pick = rng.choice(len(blobs), count, p=blobs[:, 3] ** 2 / (blobs[:, 3] ** 2).sum())
    direction = rng.standard_normal((count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    radius = blobs[pick, 3] * rng.uniform(0.72, 1.06, count)
    place = blobs[pick, :3] + direction * radius[:, None] * np.array([1, -1, 1])
    middle = blobs[:, :3].mean(0)
    outward = (place - middle) * np.array([1, -1, 1])
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-6)
    normal = direction * 0.6 + outward * 0.55
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    reach = np.abs(place - middle).max(0)
    depth = 1 - np.clip(np.linalg.norm((place - middle) / np.maximum(reach, 1), axis=1), 0, 1)
    facing = normal @ sun
    direct = np.clip(facing, 0, 1) * (1 - 0.75 * depth)
    through = 0.34 * np.clip(-sun[2], 0, 1) * (1 - depth) ** 2 * np.clip(0.6 + outward @ sun, 0, 1)
    open_sky = (0.30 + 0.70 * np.clip(0.5 + 0.5 * normal[:, 1], 0, 1)) * (1 - 0.65 * depth)
    tint = (1 + rng.normal(0, 0.15, (count, 1))) * np.stack(
        [1 - (warm := rng.normal(0, 0.10, count)), np.ones(count), 1 + warm], axis=1
    )
    light = direct[:, None] * weather.sun + open_sky[:, None] * weather.ambient
    light += through[:, None] * weather.sun * np.array([0.45, 1.3, 0.9])
    shades = np.sqrt(np.clip(lin(*colour) * tint * light / _SCALE, 0, 1)) * 255
    size = leaf * rng.uniform(0.55, 1.35, count)
    axes = np.round(np.stack([size, size * squash * rng.uniform(0.45, 0.8, count)], axis=1) * 16).astype(int)
    angles = rng.uniform(0, 180, count)
    order = np.argsort(place[:, 2])
    centres = np.round(place[:, :2] * 16).astype(int)
    for centre, axis, angle, shade in zip(
        centres[order].tolist(), axes[order].tolist(), angles[order].tolist(), shades[order].tolist(), strict=True
    ):
        cv2.ellipse(bgra, centre, axis, angle, 0, 360, (*shade, 255), -1, cv2.LINE_8, 4)


def _wood(
    rng: np.random.Generator, weather: Weather, bgra: NDArray[np.uint8], w: float, base: float, top: float, thick: float
) -> None:
    sun = _sun_in_picture(weather)
    for k in range(int(thick)):
        x = w / 2 - thick / 2 + k
        n = (k + 0.5) / thick * 2 - 1
        normal = np.array([n, 0.1, np.sqrt(max(1 - n * n, 0))])
        light = weather.sun * np.float32(max(float(normal @ sun), 0.0) * 0.8) + weather.ambient * np.float32(0.4)
        shade = lin(92, 78, 62) * light * np.float32(rng.uniform(0.75, 1.2))
        lean = rng.normal(0, 1.0)
        cv2.line(bgra, (int(x), int(base)), (int(x * 0.6 + w * 0.2 + lean), int(top)), _encode(shade), 2)
    for _ in range(7):
        start = rng.uniform(0.1, 0.8)
        y = base + (top - base) * (0.35 + 0.5 * start)
        tip = (int(w / 2 + rng.uniform(-0.22, 0.22) * w), int(y + (top - base) * rng.uniform(0.1, 0.3)))
        shade = lin(80, 68, 54) * (weather.ambient * np.float32(0.5) + weather.sun * np.float32(0.15))
        cv2.line(bgra, (int(w / 2), int(y)), tip, _encode(shade), max(2, int(thick * 0.35)))


def broadleaf(
    rng: np.random.Generator, weather: Weather, *, slim: float = 1.0, clear: float = 0.22, size: int = 448
) -> list[Patch]:
    """A deciduous tree; `slim` narrows its crown, `clear` is the share of bare trunk. Width to height is 0.8."""
    h, w = size * 2, int(size * 2 * 0.8)
    bgra = np.zeros((h, w, 4), np.uint8)
    _wood(rng, weather, bgra, w, h - 1, h * 0.35, w * rng.uniform(0.035, 0.05))
    low, high = h * (1 - clear), h * 0.03
    middle, tall, wide = (low + high) / 2, (low - high) / 2, w * 0.46 * slim
    blobs = []
    for _ in range(34):
        v = rng.standard_normal(3)
        v *= rng.uniform(0.3, 0.80) / np.linalg.norm(v)
        r = rng.uniform(0.12, 0.29) * min(wide, tall)
        taper = 1 - 0.25 * max(-v[1], 0)
        blobs.append([w / 2 + v[0] * (wide - r * 0.4) * taper, middle + v[1] * (tall - r * 0.5), v[2] * wide * 0.8, r])
    green = [(82, 104, 44), (72, 98, 46), (98, 112, 48), (66, 90, 50), (104, 108, 44)][int(rng.integers(5))]
    _leaves(rng, weather, np.array(blobs), 9000, size * 0.0115, green, bgra)
    return _finish(bgra)


def conifer(rng: np.random.Generator, weather: Weather, size: int = 448) -> list[Patch]:
    """A spruce. Width to height is 0.45."""
    h, w = size * 2, int(size * 2 * 0.45)
    bgra = np.zeros((h, w, 4), np.uint8)
    _wood(rng, weather, bgra, w, h - 1, h * 0.5, w * 0.06)
    blobs = []
    for level in np.linspace(0.02, 0.9, 22):
        reach = w * 0.46 * (0.04 + level**0.9) * rng.uniform(0.8, 1.08)
        for _ in range(5):
            angle = rng.uniform(0, 2 * np.pi)
            r = 0.12 * w * (0.34 + level)
            blobs.append(
                [w / 2 + np.cos(angle) * max(reach - r, 0), h * (0.03 + 0.93 * level), np.sin(angle) * reach, r]
            )
    _leaves(rng, weather, np.array(blobs), 5200, size * 0.0125, (46, 66, 44), bgra, 0.8)
    return _finish(bgra)


def bush(rng: np.random.Generator, weather: Weather, size: int = 224) -> list[Patch]:
    """A bush that reaches the ground. Width to height is 1.3."""
    h, w = size * 2, int(size * 2 * 1.3)
    bgra = np.zeros((h, w, 4), np.uint8)
    blobs = []
    for _ in range(16):
        r = rng.uniform(0.14, 0.26) * h
        blobs.append([rng.uniform(0.2, 0.8) * w, h - r * rng.uniform(0.7, 2.4), rng.uniform(-0.3, 0.3) * w, r])
    green = [(78, 98, 46), (92, 104, 52), (70, 88, 44)][int(rng.integers(3))]
    _leaves(rng, weather, np.array(blobs), 4500, size * 0.017, green, bgra)
    return _finish(bgra)


def grove(rng: np.random.Generator, trees: list[list[Patch]], height: int = 224) -> list[Patch]:
    """The edge of a wood, composed of trees. Width to height is 3.4.

    Args:
        rng: Source of the order and the sizes.
        trees: Pictures of single trees.
        height: Height of the picture, pixels.
    """
    width = int(height * 3.4)
    out = np.zeros((height, width, 4), np.float32)
    spots = np.sort(rng.uniform(0.0, 1.0, 17))
    for k in rng.permutation(17):
        tree = trees[int(rng.integers(len(trees)))][0]
        tall = int(height * rng.uniform(0.55, 0.98))
        wide = max(4, int(tall * tree.shape[1] / tree.shape[0]))
        x = int(spots[k] * (width - wide))
        small = cv2.resize(tree, (wide, tall), interpolation=cv2.INTER_AREA) * np.array([1, 1, 1, 1], np.float32)
        small[..., :3] *= np.float32(rng.uniform(0.75, 1.1))
        region = out[height - tall :, x : x + wide]
        region *= 1 - small[..., 3:]
        region += small
    for _ in range(60):
        r = height * rng.uniform(0.05, 0.09)
        x = int(rng.uniform(r, width - r))
        spot = trees[int(rng.integers(len(trees)))][2]
        h, w = spot.shape[:2]
        piece = cv2.resize(
            spot[int(h * 0.2) : int(h * 0.6), int(w * 0.25) : int(w * 0.75)],
            (int(2 * r), int(1.6 * r)),
            interpolation=cv2.INTER_AREA,
        )
        x0 = min(max(x - int(r), 0), width - piece.shape[1])
        region = out[height - piece.shape[0] :, x0 : x0 + piece.shape[1]]
        region *= 1 - piece[..., 3:]
        region += piece * np.array([0.75, 0.75, 0.75, 1], np.float32)
    return mipmaps(out)


def hedge(rng: np.random.Generator, weather: Weather, size: int = 160) -> list[Patch]:
    """A piece of a trimmed hedge, to be placed in rows. Width to height is 2.2."""
    h, w = size * 2, int(size * 2 * 2.2)
    bgra = np.zeros((h, w, 4), np.uint8)
    r = 0.16 * h
    blobs = [
        [x, y, rng.uniform(-20, 20), r * rng.uniform(0.9, 1.15)]
        for x in np.linspace(r, w - r, 13)
        for y in np.linspace(r * 1.1, h - r * 0.4, 5)
    ]
    _leaves(rng, weather, np.array(blobs), 9000, size * 0.030, (62, 82, 44), bgra)
    return _finish(bgra)


def tuft(rng: np.random.Generator, weather: Weather, size: int = 96) -> list[Patch]:
    """Grass blades with a few heads. Width to height is 1.6."""
    h, w = size * 2, int(size * 2 * 1.6)
    bgra = np.zeros((h, w, 4), np.uint8)
    sun = _sun_in_picture(weather)
    lit = max(sun[1] * 0.5 + 0.3 * max(sun[2], 0), 0) + 0.2 * max(-sun[2], 0)
    for _ in range(150):
        x = w / 2 + rng.normal(0, 0.19) * w
        tall = h * rng.uniform(0.25, 0.95) * np.exp(-(((x - w / 2) / (0.36 * w)) ** 2))
        bend = rng.normal(0, 0.25) * tall
        t = np.linspace(0, 1, 8)
        points = np.stack([x + bend * t**2, h - tall * t], axis=1)
        colour = lin(*[(104, 116, 52), (136, 132, 74), (88, 104, 46)][int(rng.integers(3))]) * np.float32(
            rng.uniform(0.6, 1.15)
        )
        light = weather.sun * np.float32(lit) + weather.ambient * np.float32(0.7)
        pen = int(rng.integers(2, 4))
        line = [np.round(points * 16).astype(np.int32)]
        cv2.polylines(bgra, line, False, _encode(colour * light), pen, cv2.LINE_8, 4)
    return _finish(bgra)
