"""Bodies of flat faces, each shaded separately and painted from far to near; boxes and prisms to build them from."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.camera import NEAR
from sample_videos.colour import Linear
from sample_videos.scene_objects import BEAM, UP, View, cast, clip_near, darken, headlamp, hull, to_pixels

Array = NDArray[np.float64]
Span = tuple[float, float]


@dataclass
class Face:
    """A flat polygon of a body.

    Attributes:
        points: (n, 3) in the body's frame: right, up, forward.
        colour: Linear albedo (b, g, r).
        gloss: Share of the sky that it mirrors, 0 to 1.
        own: Radiance that it emits.
    """

    points: Array
    colour: Linear
    gloss: float = 0.0
    own: float = 0.0


class Mesh:
    """Flat faces with derived values that painting needs.

    Args:
        faces: The faces.

    Attributes:
        count: Number of faces.
        points: All corners, (n, 3).
        normals: Unit normals, (count, 3).
        centres: Middles of the faces, (count, 3).
    """

    def __init__(self, faces: list[Face]) -> None:
        self.count = len(faces)
        self.points = np.concatenate([face.points for face in faces])
        ends = np.cumsum([len(face.points) for face in faces])
        self.spans = list(zip((ends - [len(face.points) for face in faces]).tolist(), ends.tolist(), strict=True))
        first = np.array([face.points[:3] for face in faces])
        normals = np.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])
        self.normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        self.centres = np.array([face.points.mean(0) for face in faces])
        self.colours = np.array([face.colour for face in faces], np.float32)
        self.gloss = np.array([face.gloss for face in faces], np.float32)[:, None]
        self.own = np.array([face.own for face in faces], np.float32)[:, None]


@dataclass
class Body:
    """A mesh in the world; its faces are shaded separately and painted from far to near.

    Attributes:
        mesh: The faces, in a frame of right, up, forward.
        origin: World position of the frame.
        right: World direction of the frame's first axis.
        forward: World direction of its third axis.
        shades: Whether it casts a shadow.
        velocity: World velocity, for motion blur.
        sorting: Point in the frame that orders it by depth.
        large: Whether light differs from face to face.
    """

    mesh: Mesh
    origin: Array
    right: Array
    forward: Array
    shades: bool = True
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    sorting: Array = field(default_factory=lambda: np.zeros(3))
    large: bool = False

    def world(self, points: Array) -> Array:
        """Convert points of the frame to the world."""
        return np.asarray(self.origin + points @ np.stack([self.right, UP, self.forward]))

    @property
    def place(self) -> Array:
        """The point that orders it by depth."""
        return self.world(self.sorting)

    def _colours(
        self, view: View, sight: Array, normals: Array, centres: Array, chosen: NDArray[np.intp]
    ) -> NDArray[np.float32]:
        """Radiance of the chosen faces; `sight` is the unit direction to the camera."""
        mesh, w = self.mesh, view.weather
        if self.large:
            lit = np.array([view.lit(c) for c in centres], np.float32)
        else:
            lit = np.repeat(np.array([view.lit(self.place + UP)], np.float32), len(centres), axis=0)
        sun, sky = lit[:, :1], lit[:, 1:]
        direct = np.maximum(normals @ w.to_sun, 0).astype(np.float32)[:, None] * sun
        light = w.sun * direct + w.ambient * ((0.55 + 0.45 * normals[:, 1:2].astype(np.float32)) * sky)
        if w.lamps:
            light = light + headlamp(view.camera.to_camera(centres))[:, None] * BEAM
        out = mesh.colours[chosen] * light + mesh.own[chosen]
        facing = (normals * sight).sum(1, keepdims=True)
        mirror = 2 * facing * normals - sight
        fresnel = mesh.gloss[chosen] * (0.10 + 0.90 * (1 - np.clip(facing, 0, 1)).astype(np.float32) ** 4)
        above = np.clip(mirror[:, 1:2] * 2, 0, 1).astype(np.float32)
        reflected = (
            np.where(mirror[:, 1:2] < 0, w.ambient * np.float32(0.12), w.horizon + (w.zenith - w.horizon) * above) * sky
        )
        spot = np.maximum(mirror @ w.to_sun, 0).astype(np.float32)[:, None] ** 60 * sun
        return np.asarray(out + fresnel * (reflected + w.sun * (4 * spot)), np.float32)

    def draw(self, view: View) -> None:
        """Paint it on a patch with a higher resolution than the picture."""
        camera, mesh = view.camera, self.mesh
        axes = np.stack([self.right, UP, self.forward])
        normals, centres = mesh.normals @ axes, self.world(mesh.centres)
        sight = camera.position - centres
        distance = np.linalg.norm(sight, axis=1)
        sight = sight / distance[:, None]
        local = camera.to_camera(self.world(mesh.points))
        chosen = np.flatnonzero((normals * sight).sum(1) > 0)
        if len(chosen) == 0 or local[:, 2].max() < NEAR:
            return
        colours = self._colours(view, sight[chosen], normals[chosen], centres[chosen], chosen)
        painted: list[tuple[float, Array, Linear]] = []
        for k, colour in zip(chosen, colours, strict=True):
            a, b = mesh.spans[k]
            points = local[a:b]
            if points[:, 2].min() < NEAR:
                points = clip_near(points)
                if len(points) < 3:
                    continue
            painted.append((float(distance[k]), to_pixels(camera, points), colour))
        if not painted:
            return
        every = np.concatenate([p for _, p, _ in painted])
        x0, y0 = np.maximum(np.floor(every.min(0)).astype(int) - 1, -8)
        x1, y1 = np.minimum(np.ceil(every.max(0)).astype(int) + 1, [camera.width + 8, camera.height + 8])
        if x1 <= x0 or y1 <= y0:
            return
        fine = 4 if max(x1 - x0, y1 - y0) < 160 else 2
        patch = np.zeros(((y1 - y0) * fine, (x1 - x0) * fine, 4), np.float32)
        for _, pixels, colour in sorted(painted, key=lambda item: -item[0]):
            scaled = np.round(((pixels - np.array([x0, y0])) * fine - 0.5) * 16).astype(np.int32)
            cv2.fillPoly(patch, [scaled], (float(colour[0]), float(colour[1]), float(colour[2]), 1.0), cv2.LINE_8, 4)
        patch = cv2.resize(patch, (int(x1 - x0), int(y1 - y0)), interpolation=cv2.INTER_AREA)
        patch = view.air(patch, self.place)
        view.film.blend(patch, int(x0), int(y0), view.blur(self.place, self.velocity))

    def shadow(self, mask: NDArray[np.uint8], view: View) -> None:
        """Cast the hull of its points on the ground."""
        if not self.shades or not -15 < view.camera.to_camera(self.place)[2] < 150:
            return
        points = self.world(self.mesh.points)
        if view.weather.sun.max() > 0.3:
            outline = hull(cast(points, view.weather))
            darken(mask, view, outline, 10)


def box(x: Span, y: Span, z: Span, colour: Linear, gloss: float = 0.0, own: float = 0.0) -> list[Face]:
    """The six faces of a box, facing outwards; each span is the box's extent along an axis of the frame, metres."""
    p = np.array([[*at] for at in itertools.product(sorted(x), sorted(y), sorted(z))], np.float64)
    order = [(0, 4, 6, 2), (5, 1, 3, 7), (1, 0, 2, 3), (4, 5, 7, 6), (2, 6, 7, 3), (1, 5, 4, 0)]
    return [Face(outward(p[list(corners)], p.mean(0)), colour, gloss, own) for corners in order]


def outward(points: Array, middle: Array) -> Array:
    """Order a polygon so that its normal (right-hand rule in X, Y, Z as used here) points away from a middle."""
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    return points if float(normal @ (points.mean(0) - middle)) > 0 else points[::-1].copy()


def prism(
    x: float, z: float, radius: float, y0: float, y1: float, colour: Linear, sides: int = 8, gloss: float = 0.0
) -> list[Face]:
    """An upright prism: a pole."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ring = np.stack([x + radius * np.cos(angle), np.zeros(sides), z + radius * np.sin(angle)], axis=1)
    low, high = ring + UP * y0, ring + UP * y1
    middle = np.array([x, (y0 + y1) / 2, z])
    walls = [np.stack([low[k - 1], low[k], high[k], high[k - 1]]) for k in [*range(1, sides), 0]]
    faces = [Face(outward(wall, middle), colour, gloss) for wall in walls]
    faces.append(Face(outward(high.copy(), middle), colour))
    return faces
