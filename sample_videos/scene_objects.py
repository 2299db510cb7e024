"""Objects on the ground: billboards and textured plates, painted in perspective, and their view."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.camera import NEAR, Camera
from sample_videos.colour import Linear
from sample_videos.linear_canvas import LinearCanvas, Patch, motion_blur_kernel
from sample_videos.weather import Weather

Array = NDArray[np.float64]
UP = np.array([0.0, 1.0, 0.0])
_MAX_BILLBOARD_PX = 5200
"""Largest width of a painted billboard, px; larger ones are left out."""
BEAM = np.array([0.78, 0.94, 1.0], np.float32)
"""Colour of our headlamps, (b, g, r)."""


def headlamp(local: Array) -> NDArray[np.float32]:
    """Light of our own headlamps at points (n, 3) of the camera's frame."""
    z = np.maximum(local[:, 2], 2.0)
    beam = np.exp(-((local[:, 0] / z / 0.28) ** 2) - ((local[:, 1] / z - 0.01) / 0.11) ** 2)
    return np.asarray(26 * beam / (20 + z**1.5), np.float32)


@dataclass
class View:
    """One moment as the camera sees it.

    Attributes:
        camera: Camera at the middle of the exposure.
        later: Camera a thousandth of a second later without its shake: the car's own motion.
        weather: Light and air.
        film: The picture to paint on.
        haze_colour: Radiance of the air.
        lit: Shares of sun and sky that reach a ground point (x, y, z): (sun, sky), each 0 to 1.
    """

    camera: Camera
    later: Camera
    weather: Weather
    film: LinearCanvas
    haze_colour: Linear
    lit: Callable[[Array], tuple[float, float]]

    def light(self, point: Array, normal: Array) -> Linear:
        """Light on a surface at a point with a normal."""
        sun, sky = self.lit(point)
        w = self.weather
        direct = max(0.0, float(normal @ w.to_sun)) * sun
        out = w.sun * direct + w.ambient * ((0.55 + 0.45 * float(normal[1])) * sky)
        if w.lamps:
            out = out + headlamp(self.camera.to_camera(point)[None])[0] * BEAM
        return np.asarray(out, np.float32)

    def air(self, patch: Patch, point: Array) -> Patch:
        """Add the air between the camera and a patch."""
        through = self.weather.haze(float(np.linalg.norm(point - self.camera.position)))
        if through > 0.985:
            return patch
        mix = np.zeros((4, 4), np.float32)
        mix[[0, 1, 2], [0, 1, 2]] = through
        mix[:3, 3] = self.haze_colour * np.float32(1 - through)
        mix[3, 3] = 1
        return np.asarray(cv2.transform(patch, mix), np.float32)

    def blur(self, point: Array, velocity: Array) -> Patch | None:
        """Line kernel of a point's motion during the exposure, without the camera's shake."""
        here = self.camera.to_camera(point)
        if here[2] < NEAR or here[2] > 50:
            return None
        offset = velocity * 1e-3 - (self.later.position - self.camera.position)
        move = (self.camera.project(point + offset) - self.camera.project(point)) * 1e3 * self.weather.shutter
        return motion_blur_kernel(float(move[0]), float(move[1]))


class SceneObject(Protocol):
    """An object with a place that can be painted and casts a shadow."""

    @property
    def place(self) -> Array:
        """A world point that orders things by depth."""
        ...

    def draw(self, view: View) -> None:
        """Paint it."""
        ...

    def shadow(self, mask: NDArray[np.uint8], view: View) -> None:
        """Darken a ground mask of the picture's size (255 is full sun) where the object blocks the sun."""
        ...


def clip_near(points: Array) -> Array:
    """Cut a camera-space polygon at the near plane."""
    out: list[Array] = []
    for a, b in zip(points, np.roll(points, -1, 0), strict=True):
        inside_a, inside_b = a[2] > NEAR, b[2] > NEAR
        if inside_a:
            out.append(a)
        if inside_a != inside_b:
            out.append(a + (b - a) * (NEAR - a[2]) / (b[2] - a[2]))
    return np.array(out).reshape(-1, 3)


def to_pixels(camera: Camera, local: Array) -> Array:
    """Project camera-space points (n, 3) before the camera to picture points within the drawable range."""
    points = local[:, :2] / local[:, 2:] * camera.focal + np.array(camera.centre)
    return np.asarray(np.clip(points, -8000, 8000))


def darken(mask: NDArray[np.uint8], view: View, ground: Array, value: int = 0) -> None:
    """Fill a polygon on the ground, in world coordinates, in a shadow mask."""
    local = clip_near(view.camera.to_camera(ground))
    if len(local) < 3:
        return
    pixels = to_pixels(view.camera, local)
    if (pixels.max(0) >= 0).all() and (pixels.min(0) <= mask.shape[::-1]).all():
        cv2.fillPoly(mask, [np.round((pixels - 0.5) * 16).astype(np.int32)], value, cv2.LINE_AA, 4)


def cast(points: Array, weather: Weather) -> Array:
    """Project world points to the ground along the sun's rays."""
    ray = weather.to_sun
    slope = ray / max(float(ray[1]), 0.12)
    return np.asarray(points - np.maximum(points[..., 1:2], 0) * slope)


@dataclass
class Billboard:
    """A premultiplied picture that always faces the camera, with its foot on the ground.

    Attributes:
        place: Foot, world.
        levels: Successive halvings of the picture.
        width: Width in metres.
        height: Height in metres.
        shades: Whether it casts a shadow.
    """

    place: Array
    levels: list[Patch]
    width: float
    height: float
    shades: bool = True

    def draw(self, view: View) -> None:
        """Paint it."""
        camera = view.camera
        local = camera.to_camera(self.place)
        if local[2] < 0.8:
            return
        top = camera.project(self.place + UP * self.height)
        foot = camera.project(self.place)
        scale = camera.focal / local[2]
        w = self.width * scale
        is_beside = foot[0] + w < 0 or foot[0] - w > camera.width or top[1] > camera.height or foot[1] < 0
        if not 0.7 <= w <= _MAX_BILLBOARD_PX or is_beside:
            return
        level = 0
        while level + 1 < len(self.levels) and self.levels[level].shape[1] > 1.6 * w:
            level += 1
        picture = self.levels[level]
        h, pw = picture.shape[:2]
        side = np.array([-(top - foot)[1], (top - foot)[0]])
        side = side / max(np.hypot(*side), 1e-6) * w / 2
        corners = np.stack([top - side, top + side, foot - side])
        x0, y0 = np.floor(np.minimum(corners.min(0), foot + side)).astype(int) - 1
        x1, y1 = np.ceil(np.maximum(corners.max(0), foot + side)).astype(int) + 1
        x0, y0, x1, y1 = max(x0, -40), max(y0, -40), min(x1, camera.width + 40), min(y1, camera.height + 40)
        if x1 <= x0 or y1 <= y0:
            return
        source = np.array([[-0.5, -0.5], [pw - 0.5, -0.5], [-0.5, h - 0.5]], np.float32)
        target = (corners - np.array([x0, y0]) - 0.5).astype(np.float32)
        matrix = cv2.getAffineTransform(source, target)
        patch = cv2.warpAffine(
            picture, matrix, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT
        )
        sun, sky = view.lit(self.place)
        gain = 0.35 * sky + 0.65 * sun * sky
        if gain < 0.99:
            patch[..., :3] *= np.float32(gain)
        patch = view.air(patch, self.place)
        view.film.blend(patch, x0, y0, view.blur(self.place, np.zeros(3)))

    def shadow(self, mask: NDArray[np.uint8], view: View) -> None:
        """Cast the picture's silhouette on the ground."""
        local = view.camera.to_camera(self.place)
        if not self.shades or not -30 < local[2] < 90 or view.weather.sun.max() < 0.3:
            return
        ray = view.weather.to_sun
        across = np.cross(UP, ray)
        across = across / np.linalg.norm(across) * self.width / 2
        top = cast((self.place + UP * self.height)[None], view.weather)[0]
        quad = np.stack([top - across, top + across, self.place + across, self.place - across])
        depth = view.camera.to_camera(quad)[:, 2]
        if depth.min() < 1.0:
            centre, toward = (top * 0.55 + self.place * 0.45), (top - self.place) * 0.42
            angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
            wobble = 1 + 0.16 * np.sin(5 * angle + self.place[0]) + 0.1 * np.sin(11 * angle + self.place[2])
            ring = centre + np.outer(np.cos(angle) * wobble, across * 0.9) + np.outer(np.sin(angle) * wobble, toward)
            darken(mask, view, ring, 30)
            return
        pixels = view.camera.project(quad)
        level = min(2, len(self.levels) - 1)
        alpha = self.levels[level][..., 3]
        h, w = alpha.shape
        x0, y0 = np.maximum(np.floor(pixels.min(0)).astype(int), 0)
        x1, y1 = np.minimum(np.ceil(pixels.max(0)).astype(int), [mask.shape[1], mask.shape[0]])
        if x1 - x0 < 1 or y1 - y0 < 1:
            return
        source = np.array([[0, 0], [w, 0], [w, h], [0, h]], np.float32)
        matrix = cv2.getPerspectiveTransform(source, (pixels - np.array([x0, y0])).astype(np.float32))
        dark = cv2.warpPerspective(alpha, matrix, (int(x1 - x0), int(y1 - y0)), flags=cv2.INTER_AREA)
        region = mask[y0:y1, x0:x1]
        region[:] = (region * (1 - 0.93 * dark)).astype(np.uint8)


@dataclass
class Plate:
    """A flat rectangle with a picture.

    Attributes:
        corners: (4, 3) world: upper left, upper right, lower right, lower left as seen from the front.
        levels: Successive halvings of the picture, premultiplied.
        glow: Light that the picture emits or reflects back, added to its shading.
        cull: Not painted from behind.
        shades: Whether it casts a shadow.
        velocity: World velocity, for motion blur.
    """

    corners: Array
    levels: list[Patch]
    glow: float = 0.0
    cull: bool = True
    shades: bool = False
    velocity: Array = field(default_factory=lambda: np.zeros(3))

    @property
    def place(self) -> Array:
        """Centre."""
        return np.asarray(self.corners.mean(0))

    @property
    def normal(self) -> Array:
        """Unit normal towards the front."""
        n = np.cross(self.corners[3] - self.corners[0], self.corners[1] - self.corners[0])
        return np.asarray(-n / np.linalg.norm(n))

    def project(self, view: View) -> tuple[Patch, int, int] | None:
        """The projected picture in its own colours: patch, x, y; None: not visible."""
        camera = view.camera
        local = camera.to_camera(self.corners)
        if local[:, 2].min() < NEAR:
            return None
        facing = float((camera.position - self.place) @ self.normal)
        if self.cull and facing <= 0:
            return None
        pixels = camera.project(self.corners)
        x0, y0 = np.floor(pixels.min(0)).astype(int) - 1
        x1, y1 = np.ceil(pixels.max(0)).astype(int) + 1
        if x1 < 0 or y1 < 0 or x0 > camera.width or y0 > camera.height:
            return None
        x0, y0, x1, y1 = max(x0, -200), max(y0, -200), min(x1, camera.width + 200), min(y1, camera.height + 200)
        if x1 <= x0 or y1 <= y0:
            return None
        across = max(np.hypot(*(pixels[1] - pixels[0])), np.hypot(*(pixels[2] - pixels[3])))
        down = max(np.hypot(*(pixels[3] - pixels[0])), np.hypot(*(pixels[2] - pixels[1])))
        level, n = 0, len(self.levels)
        while level + 1 < n and self.levels[level].shape[1] > 1.5 * across and self.levels[level].shape[0] > 1.5 * down:
            level += 1
        picture = self.levels[level]
        h, w = picture.shape[:2]
        unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
        homography = cv2.getPerspectiveTransform(unit, (pixels - np.array([x0, y0])).astype(np.float32))
        half = np.array([[1, 0, -0.5], [0, 1, -0.5], [0, 0, 1.0]])
        matrix = half @ homography @ np.array([[1 / w, 0, 0.5 / w], [0, 1 / h, 0.5 / h], [0, 0, 1.0]])
        patch = cv2.warpPerspective(picture, matrix, (int(x1 - x0), int(y1 - y0)), flags=cv2.INTER_LINEAR)
        return patch, int(x0), int(y0)

    def draw(self, view: View) -> None:
        """Paint it."""
        self.paint(view)

    def paint(self, view: View) -> tuple[Patch, int, int] | None:
        """Paint it and return its coverage with its place; None: not visible."""
        projected = self.project(view)
        if projected is None:
            return None
        patch, x, y = projected
        coverage = patch[..., 3].copy()
        normal = self.normal
        if not self.cull and float((view.camera.position - self.place) @ normal) < 0:
            normal = -normal
        patch[..., :3] *= view.light(self.place, normal) + np.float32(self.glow)
        patch = view.air(patch, self.place)
        view.film.blend(patch, x, y, view.blur(self.place, self.velocity))
        return coverage, x, y

    def shadow(self, mask: NDArray[np.uint8], view: View) -> None:
        """Cast its rectangle on the ground."""
        if self.shades and view.weather.sun.max() > 0.3 and -15 < view.camera.to_camera(self.place)[2] < 120:
            darken(mask, view, cast(self.corners, view.weather))


def rectangle(centre: Array, half_across: Array, half_up: Array) -> Array:
    """Corners of a rectangle about a point for :class:`Plate`, (4, 3); the vectors lead to its right and upper side."""
    left, right = centre - half_across, centre + half_across
    return np.stack([left + half_up, right + half_up, right - half_up, left - half_up])


def hull(ground: Array) -> Array:
    """Convex hull of points on the ground."""
    ring = cv2.convexHull(ground[:, [0, 2]].astype(np.float32))[:, 0].astype(np.float64)
    return np.stack([ring[:, 0], np.zeros(len(ring)), ring[:, 1]], axis=1)
