"""Signs on poles: their faces in the world, and their exact outlines in the picture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.camera import NEAR, Camera
from sample_videos.colour import linear_picture
from sample_videos.linear_canvas import Patch
from sample_videos.meshes import Body
from sample_videos.noise import fractal, mipmaps
from sample_videos.road_path import RoadPath
from sample_videos.scene_objects import UP, Plate, View, cast, darken, rectangle
from sample_videos.structures import pole
from tsr_engine.pictograms.gtsrb import drawing, nominal_width, outline

Array = NDArray[np.float64]
_RESOLUTION = 256


def weathered(rng: np.random.Generator, class_id: int, resolution: int = _RESOLUTION) -> list[Patch]:
    """A sign's picture as it looks outdoors, slightly faded and dirty, in successive halvings."""
    bgra = drawing(class_id).picture(resolution).astype(np.float32)
    dirt = fractal(rng, resolution, 1.1, 1)
    fade = rng.uniform(0.0, 0.10)
    grey = bgra[..., :3].mean(2, keepdims=True)
    bgra[..., :3] += (grey - bgra[..., :3]) * fade
    bgra[..., :3] *= (1 - 0.02 * np.clip(dirt, -1, 2.5))[..., None]
    bgra[..., :3] *= np.linspace(1.02, 0.96, resolution, dtype=np.float32)[:, None, None]
    return mipmaps(linear_picture(np.clip(bgra, 0, 255).astype(np.uint8)))


@dataclass
class Sign:
    """One sign of the drive.

    Attributes:
        track_id: Its number, from 1.
        class_id: GTSRB class.
        s: Arc length along the road.
        d: Distance to the right of the centre line.
        width: Nominal width in metres: the side of the square to which the unit square of its outline is scaled.
        plate: Its face.
    """

    track_id: int
    class_id: int
    s: float
    d: float
    width: float
    plate: Plate

    @property
    def place(self) -> Array:
        """Centre of the face, slightly nearer to the camera than its pole."""
        return self.plate.place

    def face(self) -> Array:
        """Outline of the face in the world, (n, 3)."""
        unit = (outline(self.class_id) + 1) / 2
        c = self.plate.corners
        u, v = unit[:, :1], unit[:, 1:]
        return np.asarray(c[0] * (1 - u) * (1 - v) + c[1] * u * (1 - v) + c[2] * u * v + c[3] * (1 - u) * v)

    def polygon(self, camera: Camera) -> Array | None:
        """Outline of the face in the picture, (n, 2) in pixel-edge coordinates; None: behind the camera."""
        points = self.face()
        if camera.to_camera(points)[:, 2].min() < NEAR:
            return None
        return camera.project(points)

    def draw(self, view: View) -> None:
        """Paint it, and let the film track its visible part."""
        painted = self.plate.paint(view)
        polygon = self.polygon(view.camera)
        if painted is not None and polygon is not None:
            coverage, x, y = painted
            view.film.watch(self.track_id, coverage, x, y, float(cv2.contourArea(polygon.astype(np.float32))))

    def shadow(self, mask: NDArray[np.uint8], view: View) -> None:
        """Cast its shadow."""
        if view.weather.sun.max() > 0.3 and -15 < view.camera.to_camera(self.place)[2] < 120:
            darken(mask, view, cast(self.face(), view.weather))


def build_sign_post(
    rng: np.random.Generator, path: RoadPath, s: float, d: float, classes: list[int], first_id: int, glow: float
) -> tuple[list[Sign], Body]:
    """Put one or two signs on a pole beside the road.

    Args:
        rng: Source of small irregularities.
        path: The road.
        s: Arc length.
        d: Distance to the right of the centre line.
        classes: GTSRB classes, from the top down.
        first_id: Number of the first sign.
        glow: Light reflected in addition to plain shading (0 by day).

    Returns:
        The signs and their pole.
    """
    right, forward = path.frame(s)
    turn = np.radians(rng.normal(0, 3.0)) - np.radians(3.0) * np.sign(d)
    across = right * np.cos(turn) + forward * np.sin(turn)
    lean = np.radians(rng.normal(0, 0.8))
    side, up = across * np.cos(lean) + UP * np.sin(lean), UP * np.cos(lean) - across * np.sin(lean)
    front = np.cross(up, side)
    front = front * np.sign(float(front @ -forward))
    foot = path.point(s, d)
    y = rng.uniform(1.75, 2.05) if len(classes) > 1 else rng.uniform(1.95, 2.2)
    signs: list[Sign] = []
    for number, class_id in reversed(list(enumerate(classes))):
        width = nominal_width(class_id)
        shape = outline(class_id)
        low, high = float(shape[:, 1].max()) * width / 2, float(-shape[:, 1].min()) * width / 2
        centre = foot + up * (y + low) + front * 0.07
        corners = rectangle(centre, side * (width / 2), up * (width / 2))
        plate = Plate(corners, weathered(rng, class_id), glow=glow, shades=True)
        signs.append(Sign(first_id + number, class_id, s, d, width, plate))
        y += low + high + 0.05
    return sorted(signs, key=lambda sign: sign.track_id), pole(foot, across, forward, float(y) - 0.02)
