"""Paints one frame of a drive."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.camera import Camera, Shake, look
from sample_videos.drive import LANE, Drive
from sample_videos.ground import Ground
from sample_videos.ground_truth import Row, make_row
from sample_videos.lens import Lens
from sample_videos.linear_canvas import LinearCanvas
from sample_videos.meshes import Body
from sample_videos.scene_objects import SceneObject, View, darken
from sample_videos.sky import Sky

Array = NDArray[np.float64]
HEIGHT = 1.3
"""Height of the camera above the road, metres."""

FIELD_OF_VIEW = 59.0
"""Horizontal field of view, degrees."""


@dataclass
class Moment:
    """One rendered frame.

    Attributes:
        picture: (height, width, 3) BGR uint8.
        rows: Ground truth of the frame.
        glare: Share of the sun that reaches the lens, 0 to 1.
    """

    picture: NDArray[np.uint8]
    rows: list[Row]
    glare: float


class Renderer:
    """Paints a drive frame by frame, in order.

    Args:
        drive: The drive.
        size: Width and height in pixels.
        fps: Frames per second.
        seed: Seed of textures, shake and sensor noise.
    """

    def __init__(self, drive: Drive, size: tuple[int, int], fps: int, seed: int) -> None:
        self.drive, self.size, self.fps = drive, size, fps
        sequence = np.random.SeedSequence([seed, 7])
        textures, shake, lens, self._noise = (np.random.default_rng(s) for s in sequence.spawn(4))
        self._sky = Sky(textures, drive.weather, 0.55 if drive.scenario.town else 1.0)
        self._ground = Ground(textures, drive.path, drive.style, drive.weather)
        self._shake = Shake(shake, drive.scenario.shake, drive.bumps)
        self._lens = Lens(lens, drive.weather, *size)
        self._places = np.array([thing.place for thing, _ in drive.things])
        self._reaches = np.array([reach for _, reach in drive.things])
        self._beam = self._headlamps() if drive.weather.lamps else None

    @property
    def focal(self) -> float:
        """Focal length in pixels."""
        return float(self.size[0] / 2 / np.tan(np.radians(FIELD_OF_VIEW / 2)))

    def camera(self, t: float, *, shaken: bool = True) -> Camera:
        """The camera at a time in seconds."""
        d = self.drive
        s = d.distance(t)
        pitch, yaw, roll, heave = self._shake.at(t) if shaken else np.zeros(4)
        aside = LANE + 0.12 * np.sin(0.6 * t)
        heading = 0.65 * d.path.heading(s) + 0.35 * d.path.heading(s + 14)
        lean = 0.25 * (d.path.heading(s + 8) - d.path.heading(s))
        position = d.path.point(s, aside, HEIGHT + heave)
        return look(*self.size, self.focal, position, heading + yaw, pitch - 0.012, roll + lean * 0.4)

    def _headlamps(self) -> NDArray[np.float32]:
        width, height = self.size
        cx, cy = width / 2, height * 0.46
        y, x = np.mgrid[0:height, 0:width].astype(np.float32) + 0.5
        z = np.where(y > cy + 1, HEIGHT * self.focal / np.maximum(y - cy, 1), 4000).astype(np.float32)
        aside = (x - cx) / self.focal
        beam = np.exp(-(((aside - 0.03) / 0.26) ** 2)) + 0.5 * np.exp(-((aside / 0.6) ** 2))
        return np.asarray(7.5 * beam / (9 + z**1.45), np.float32)

    def light_at(self, point: Array) -> tuple[float, float]:
        """Shares of sun and sky that reach a point."""
        bridge = self.drive.bridge
        if bridge is None:
            return 1.0, 1.0
        right, forward = self.drive.path.frame(bridge[0])
        origin = self.drive.path.point(bridge[0], 0.0)
        deep = bridge[1] - bridge[0]

        def below(p: Array) -> bool:
            local = p - origin
            return bool(0.3 < local @ forward < deep - 0.3 and abs(local @ right) < 44)

        sky = 0.16 if below(point) and point[1] <= 5.0 and abs((point - origin) @ right) < 8 else 1.0
        sun = self.drive.weather.to_sun
        rise = 5.6 - point[1]
        shadowed = rise > 0 and below(point + sun * rise / max(float(sun[1]), 0.05))
        return (0.0 if shadowed or sky < 1 else 1.0), sky

    def frame(self, number: int) -> Moment:
        """Paint a frame.

        Args:
            number: Its number, from 0; frames must be painted in order, because the exposure follows the scene.

        Returns:
            Picture, ground truth and glare.
        """
        d, (width, height) = self.drive, self.size
        t = number / self.fps
        camera = self.camera(t)
        steady, later = self.camera(t, shaken=False), self.camera(t + 1e-3, shaken=False)
        moved = Camera(width, height, self.focal, camera.position + later.position - steady.position, camera.axes)
        film = LinearCanvas(width, height)
        view = View(camera, moved, d.weather, film, self._sky.haze(camera), self.light_at)
        near = self._near(view, t)
        mask = np.full((height, width), 255, np.uint8)
        for thing in near:
            thing.shadow(mask, view)
        mask = cv2.GaussianBlur(mask, (0, 0), max(width / 900, 0.5))
        sun = mask.astype(np.float32) / 255
        top, ground = self._ground.shade(camera, d.distance(t), d.speed(t), sun, self._beam, view.haze_colour, d.bridge)
        self._sky.paint(camera, film.image, min(top + 4 + height // 60, height), t)
        _join(film.image, ground, top, camera)
        self._contact(film, near, view)
        for thing in near:
            thing.draw(view)
        glare = self._sun_seen(film, camera)
        self._lens.bonnet(film.image)
        ahead, behind = self.camera(t + 2e-3), self.camera(t - 2e-3)
        axis = (ahead.axes - behind.axes) / 4e-3
        road = (self.camera(t + 2e-3, shaken=False).axes - self.camera(t - 2e-3, shaken=False).axes) / 4e-3
        turn = (axis - road) @ camera.axes[2]
        rotation = (float(turn[0]) * self.focal, float(turn[1]) * self.focal)
        picture = self._lens.expose(film.image, camera, 1 / self.fps, rotation, glare, self._noise)
        seen = {w.track_id: w.visibility() for w in film.watched}
        rows = []
        for sign in d.signs:
            polygon = sign.polygon(camera) if sign.track_id in seen else None
            if polygon is None:
                continue
            (x1, y1), (x2, y2) = polygon.min(0).tolist(), polygon.max(0).tolist()
            made = make_row(number, sign.track_id, (x1, y1, x2, y2), self.size, sign.class_id, seen[sign.track_id])
            if made is not None:
                rows.append(made)
        return Moment(picture, rows, glare)

    def _near(self, view: View, t: float) -> list[SceneObject]:
        """Things that may be visible or cast a shadow into view, from far to near."""
        local = view.camera.to_camera(self._places)
        distance = np.hypot(local[:, 0], local[:, 2])
        in_view = np.abs(local[:, 0]) < np.maximum(local[:, 2], 0) * 0.75 + 45
        kept = np.flatnonzero((local[:, 2] > -32) & (distance < self._reaches) & in_view)
        chosen: list[tuple[float, SceneObject]] = [(float(distance[k]), self.drive.things[k][0]) for k in kept]
        for mover in self.drive.movers:
            body = mover.body(self.drive.path, t)
            if body is not None:
                z = float(view.camera.to_camera(body.origin)[2])
                if -12 < z < 450:
                    chosen.append((float(np.linalg.norm(body.origin - view.camera.position)), body))
        return [thing for _, thing in sorted(chosen, key=lambda item: -item[0])]

    def _contact(self, film: LinearCanvas, near: list[SceneObject], view: View) -> None:
        """Darken the ground below vehicles, where little light of the sky arrives."""
        mask = np.full(film.image.shape[:2], 255, np.uint8)
        used = False
        for thing in near:
            if isinstance(thing, Body) and thing.mesh.count > 60 and 1 < view.camera.to_camera(thing.origin)[2] < 160:
                points = thing.mesh.points
                (x0, _, z0), (x1, _, z1) = points.min(0), points.max(0)
                if z1 - z0 > 12:
                    continue
                ring = np.array([[x0, 0, z0], [x1, 0, z0], [x1, 0, z1], [x0, 0, z1]]) * np.array([1.0, 0, 0.98])
                darken(mask, view, thing.world(ring), 60)
                used = True
        if used:
            mask = cv2.GaussianBlur(mask, (0, 0), max(film.image.shape[1] / 420, 0.5))
            film.image *= (mask.astype(np.float32) / 255)[..., None]

    def _sun_seen(self, film: LinearCanvas, camera: Camera) -> float:
        """Share of the sun's disc that is not covered; a constant while it is outside the picture."""
        w = self.drive.weather
        local = camera.axes @ w.to_sun
        if w.cover > 0.9 or local[2] <= 0.2 or w.sun.max() < 1:
            return 0.0
        x = int(local[0] / local[2] * camera.focal + camera.centre[0])
        y = int(local[1] / local[2] * camera.focal + camera.centre[1])
        r = max(3, int(camera.focal * np.radians(0.5)))
        if not (r <= x < camera.width - r and r <= y < camera.height - r):
            return 0.4 if self.light_at(camera.position)[1] == 1.0 else 0.0
        window = film.image[y - r : y + r, x - r : x + r].max(2)
        return float(np.clip((window > 15).mean() / 0.45, 0, 1))


def _join(image: NDArray[np.float32], ground: NDArray[np.float32], top: int, camera: Camera) -> None:
    """Copy the ground over the sky below the horizon."""
    _, dy, _ = camera.rays(top, camera.height)
    cover = np.clip(0.5 - dy * np.float32(camera.focal), 0, 1)
    mixed = min(len(cover), 80 + camera.height // 8)
    part = cover[:mixed, :, None]
    image[top : top + mixed] = image[top : top + mixed] * (1 - part) + ground[:mixed] * part
    image[top + mixed :] = ground[mixed:]
