"""Built things: houses, bridges, guard rails, kerb posts, lamp posts."""

from __future__ import annotations

import itertools

import cv2
import numpy as np
from numpy.typing import NDArray

from sample_videos.colour import Linear, lin, linear_picture, opaque
from sample_videos.linear_canvas import Patch
from sample_videos.meshes import Body, Face, Mesh, box, outward, prism
from sample_videos.noise import fractal, mipmaps
from sample_videos.scene_objects import UP, Plate, SceneObject, View, cast, darken, hull

Array = NDArray[np.float64]

_PLASTER = (
    (222, 212, 190), (206, 196, 180), (228, 224, 214), (200, 168, 130), (190, 196, 190), (214, 184, 150), (150, 84, 66),
)  # fmt: skip
_TILES = ((132, 66, 46), (104, 56, 44), (76, 72, 74), (146, 84, 56))


def _textured(
    rng: np.random.Generator, h: int, w: int, colour: tuple[int, int, int], strength: float
) -> NDArray[np.float32]:
    size = 256
    plane = 0.6 * fractal(rng, size, 1.2, 1) + 0.5 * fractal(rng, size, 0.3, 8)
    plane = np.tile(plane, (h // size + 1, w // size + 1))[:h, :w]
    return np.clip(np.array(colour[::-1], np.float32) * (1 + strength * plane[..., None]), 0, 255).astype(np.float32)


def _window(
    image: NDArray[np.float32],
    rng: np.random.Generator,
    x: int,
    y: int,
    w: int,
    h: int,
    lit: bool,
    glow: NDArray[np.float32],
) -> None:
    cv2.rectangle(image, (x - 3, y - 3), (x + w + 3, y + h + 5), (196, 200, 200), -1)
    warm = lit and rng.random() < 0.5
    top, low = ((150, 215, 255), (90, 160, 225)) if warm else ((112, 98, 84), (52, 46, 42))
    for k in range(h):
        f = k / h
        colour = tuple(float(a * (1 - f) + b * f) for a, b in zip(top, low, strict=True))
        cv2.line(image, (x, y + k), (x + w, y + k), colour, 1)
    if warm:
        glow[y : y + h, x : x + w] = 1
    curtain = int(w * rng.uniform(0.12, 0.3))
    if rng.random() < 0.7 and not warm:
        for left in (x, x + w - curtain):
            part = image[y : y + h, left : left + curtain]
            part[:] = part * 0.5 + np.array([90, 96, 98])
    cv2.line(image, (x + w // 2, y), (x + w // 2, y + h), (200, 204, 204), 3)
    cv2.line(image, (x, y + h // 3), (x + w, y + h // 3), (200, 204, 204), 2)
    image[y + h + 5 : y + h + 12, x - 5 : x + w + 5] *= 0.72


def _wall(
    rng: np.random.Generator,
    width: float,
    height: float,
    gable: float,
    colour: tuple[int, int, int],
    lit: bool,
    door: bool,
) -> list[Patch]:
    """A wall's picture, `gable` metres of triangle on top of it, as halvings of a premultiplied picture."""
    scale = 40
    w, h, g = int(width * scale), int(height * scale), int(gable * scale)
    image = _textured(rng, h + g, w, colour, 0.035)
    image *= np.linspace(1.02, 0.9, h + g, dtype=np.float32)[:, None, None]
    image[-int(0.5 * scale) :] *= 0.66
    glow = np.zeros((h + g, w), np.float32)
    floors = max(1, int(height // 2.7))
    columns = max(1, int(width // 2.6))
    for floor in range(floors):
        for column in range(columns):
            x = int((column + 0.5) * w / columns - 0.55 * scale)
            y = int(g + h - (floor + 1) * h / floors + 0.62 * scale)
            if door and floor == 0 and column == columns // 2:
                cv2.rectangle(image, (x, y - 4), (x + int(1.1 * scale), g + h), (52, 66, 84), -1)
                cv2.rectangle(image, (x + 6, y + 4), (x + int(0.95 * scale), y + 28), (90, 84, 78), -1)
                continue
            _window(image, rng, x, y, int(1.1 * scale), int(1.3 * scale), lit, glow)
    if g > 2.0 * scale:
        x, y = int(w / 2 - 0.5 * scale), int(g - 1.0 * scale)
        _window(image, rng, x, y, int(1.0 * scale), int(1.1 * scale), lit, glow)
    alpha = np.full((h + g, w), 255, np.uint8)
    if g:
        alpha[:g] = 0
        cv2.fillPoly(alpha, [np.array([[0, g], [w, g], [w // 2, 0]])], 255)
    picture = linear_picture(np.dstack([np.clip(image, 0, 255).astype(np.uint8), alpha]))
    picture[..., :3] *= 1 + 6 * glow[..., None]
    return mipmaps(picture)


def _roof(rng: np.random.Generator, width: float, slope: float) -> list[Patch]:
    scale = 30
    w, h = int(width * scale), int(slope * scale)
    image = _textured(rng, h, w, _TILES[int(rng.integers(len(_TILES)))], 0.10)
    for y in range(0, h, 10):
        image[y : y + 3] *= 0.72
    for x in range(0, w, 7):
        image[:, x] *= 0.86
    return mipmaps(opaque(np.clip(image, 0, 255).astype(np.uint8)))


class House:
    """A house with a pitched roof: four textured walls and two roof faces.

    Args:
        rng: Source of its look.
        centre: Middle of its ground plan.
        right: World direction along its eaves.
        forward: World direction across.
        lit: Whether some windows are lit.
    """

    def __init__(self, rng: np.random.Generator, centre: Array, right: Array, forward: Array, lit: bool) -> None:
        self._centre = centre
        long, deep = rng.uniform(9, 13), rng.uniform(7.5, 9.5)
        wall, ridge = rng.choice([3.4, 5.6, 5.9]), rng.uniform(2.6, 3.8)
        colour = _PLASTER[int(rng.integers(len(_PLASTER)))]
        self._top = wall + ridge
        self._plan = [
            centre + right * x * long / 2 + forward * z * deep / 2 for x, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        eaves = [_wall(rng, long, wall, 0.0, colour, lit, True), _wall(rng, deep, wall, ridge, colour, lit, False)]
        self._plates: list[Plate] = []
        for k in range(4):
            a, b = self._plan[k], self._plan[(k + 1) % 4]
            high = wall + (ridge if k % 2 else 0.0)
            corners = np.stack([a + UP * high, b + UP * high, b, a])
            self._plates.append(_plate_towards((a + b) / 2 - centre, corners, eaves[k % 2]))
        tiles = _roof(rng, long + 0.8, float(np.hypot(deep / 2 + 0.5, ridge + 0.3)))
        crown = centre + UP * (wall + ridge + 0.08)
        for side in (-1, 1):
            low = centre + forward * side * (deep / 2 + 0.5) + UP * (wall - 0.3)
            out = right * (long / 2 + 0.4)
            corners = np.stack([crown - out, crown + out, low + out, low - out])
            self._plates.append(_plate_towards(UP, corners, tiles))
        left, low, high = long * 0.2, wall + ridge * 0.4, wall + ridge + 0.8
        chimney = box((left, left + 0.7), (low, high), (-0.9, -0.3), lin(120, 70, 56))
        self._chimney = Body(Mesh(chimney), centre, right, forward, shades=False)

    @property
    def place(self) -> Array:
        """Middle of its ground plan."""
        return self._centre

    def draw(self, view: View) -> None:
        """Paint its faces from far to near."""

        def nearness(plate: Plate) -> float:
            return -float(np.linalg.norm(plate.place - view.camera.position))

        walls, roof = sorted(self._plates[:4], key=nearness), sorted(self._plates[4:], key=nearness)
        parts: list[SceneObject] = [*walls, self._chimney, *roof]
        for part in parts:
            part.draw(view)

    def shadow(self, mask: NDArray[np.uint8], view: View) -> None:
        """Cast the hull of its corners on the ground."""
        if view.weather.sun.max() >= 0.3:
            eaves = [corner + UP * (self._top - 2.5) for corner in self._plan]
            points = np.array([*self._plan, *eaves, self._centre + UP * self._top])
            darken(mask, view, hull(cast(points, view.weather)))


def _plate_towards(direction: Array, corners: Array, levels: list[Patch]) -> Plate:
    """A plate whose front faces a direction; its corners are mirrored left to right where they would not."""
    towards = float(Plate(corners, levels).normal @ direction) >= 0
    return Plate(corners if towards else corners[[1, 0, 3, 2]], levels)


def _face_towards(direction: tuple[float, float, float], points: Array, colour: Linear) -> Face:
    """A face whose normal points in a direction of the frame: right, up, forward."""
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    return Face(points if normal @ direction > 0 else points[::-1].copy(), colour)


def lamp_post(origin: Array, right: Array, forward: Array, towards: float, lit: bool) -> Body:
    """A street lamp whose arm points to the road (`towards` is -1 or 1 along `right`)."""
    grey = lin(118, 122, 122)
    faces = prism(0, 0, 0.07, 0, 6.8, grey)
    end = towards * 1.5
    faces += box((0, end), (6.72, 6.80), (-0.04, 0.04), grey)
    faces += box((end * 0.7, end * 1.15), (6.64, 6.78), (-0.12, 0.12), lin(90, 92, 92))
    faces += box((end * 0.75, end * 1.1), (6.58, 6.64), (-0.09, 0.09), lin(250, 236, 200), own=6.0 if lit else 0.0)
    return Body(Mesh(faces), origin, right, forward)


def delineator(origin: Array, right: Array, forward: Array) -> Body:
    """A kerb post: white with a slanted black band and a reflector."""
    faces = box((-0.06, 0.06), (0, 0.62), (-0.05, 0.05), lin(226, 226, 222))
    faces += box((-0.062, 0.062), (0.62, 0.86), (-0.052, 0.052), lin(28, 28, 30))
    faces += box((-0.06, 0.06), (0.86, 1.0), (-0.05, 0.05), lin(226, 226, 222))
    faces += box((-0.025, 0.025), (0.65, 0.82), (-0.058, -0.05), lin(190, 196, 200), 0.5)
    return Body(Mesh(faces), origin, right, forward)


def rail(origin: Array, right: Array, forward: Array, length: float) -> Body:
    """A piece of guard rail along `forward`, on posts."""
    steel = lin(150, 154, 158)
    faces: list[Face] = []
    for x, y in (((-0.06, -0.02), (0.66, 0.78)), ((-0.02, 0.02), (0.58, 0.66)), ((-0.06, -0.02), (0.46, 0.58))):
        faces += box(x, y, (0, length), steel, 0.25)
    faces += box((0.0, 0.1), (0, 0.62), (0.0, 0.08), lin(116, 118, 120))
    return Body(Mesh(faces), origin, right, forward, sorting=np.array([0.0, 0.5, length / 2]))


def pole(origin: Array, right: Array, forward: Array, height: float, radius: float = 0.038) -> Body:
    """A galvanised tube."""
    return Body(Mesh(prism(0, 0, radius, 0, height, lin(138, 142, 144), 10, 0.12)), origin, right, forward)


def wooden_pole(origin: Array, right: Array, forward: Array) -> Body:
    """A wooden line pole with a cross arm."""
    faces = prism(0, 0, 0.13, 0, 7.5, lin(104, 84, 64))
    faces += box((-0.8, 0.8), (6.9, 7.05), (-0.06, 0.06), lin(96, 78, 60))
    return Body(Mesh(faces), origin, right, forward)


def bin_body(origin: Array, right: Array, forward: Array, colour: tuple[int, int, int]) -> Body:
    """A wheeled bin."""
    faces = box((-0.28, 0.28), (0.05, 1.0), (-0.3, 0.3), lin(*colour), 0.08)
    faces += box((-0.31, 0.31), (1.0, 1.07), (-0.33, 0.33), lin(*colour), 0.08)
    return Body(Mesh(faces), origin, right, forward)


def bale(origin: Array, right: Array, forward: Array) -> Body:
    """A round bale of straw with its flat side to the road: round, but not a sign."""
    angle = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    ring = np.stack([0.7 * np.cos(angle), 0.7 + 0.7 * np.sin(angle), np.zeros(20)], axis=1)
    straw: Linear = lin(186, 160, 98)
    middle = np.array([0.0, 0.7, 0.0])
    near, far = ring - np.array([0, 0, 0.6]), ring + np.array([0, 0, 0.6])
    faces = [Face(outward(near, middle), straw), Face(outward(far, middle), straw)]
    faces += [
        Face(outward(np.stack([near[k], near[(k + 1) % 20], far[(k + 1) % 20], far[k]]), middle), lin(168, 142, 84))
        for k in range(20)
    ]
    for r, shade in ((0.52, (170, 146, 88)), (0.34, (188, 164, 104)), (0.16, (160, 136, 80))):
        inner = near * np.array([r / 0.7, r / 0.7, 1]) + np.array([0, 0.7 * (1 - r / 0.7), -0.01])
        faces.append(Face(outward(inner, middle), lin(*shade)))
    return Body(Mesh(faces), origin, right, forward)


def bridge(
    rng: np.random.Generator, origin: Array, right: Array, forward: Array, depth: float, clear: float, half: float
) -> list[SceneObject]:
    """A concrete bridge: a deck `depth` metres along the road, `clear` metres high, walls `half` metres off."""
    things: list[SceneObject] = []
    tall = 1.5

    def shade() -> Linear:
        v = rng.uniform(0.9, 1.08)
        return lin(158 * v, 154 * v, 146 * v)

    deck: list[Face] = []
    xs = np.arange(-42.0, 42.1, 4.0)
    for x0, x1 in itertools.pairwise(xs):
        for z0, z1 in ((0.0, depth / 2), (depth / 2, depth)):
            if abs(x0) <= half + 4:
                under = np.array([[x0, clear, z0], [x1, clear, z0], [x1, clear, z1], [x0, clear, z1]])
                deck.append(_face_towards((0, -1, 0), under, shade()))
        front = np.array([[x0, clear, 0], [x0, clear + tall, 0], [x1, clear + tall, 0], [x1, clear, 0]])
        deck.append(_face_towards((0, 0, -1), front, shade()))
        streak = front.copy()
        streak[:, 2] -= 0.01
        streak[[1, 2], 1] = clear + 0.35
        deck.append(_face_towards((0, 0, -1), streak, shade() * np.float32(0.66)))
    for x in np.arange(-42.0, 42.0, 2.0):
        deck += box((x, x + 0.05), (clear + tall, clear + tall + 1.0), (0.1, 0.15), lin(120, 130, 134))
    deck += box((-42, 42), (clear + tall + 0.95, clear + tall + 1.02), (0.08, 0.16), lin(120, 130, 134))
    things.append(Body(Mesh(deck), origin, right, forward, large=True, sorting=np.array([0.0, 3.0, depth * 0.6])))
    grass = mipmaps(opaque(np.clip(_textured(rng, 256, 1024, (92, 108, 50), 0.16), 0, 255).astype(np.uint8)))
    for side in (-1, 1):
        wall: list[Face] = []
        x, high = side * half, clear + 0.2
        for z0 in np.arange(-1.0, depth + 1, 2.0):
            panel = np.array([[x, 0, z0], [x, high, z0], [x, high, z0 + 2.0], [x, 0, z0 + 2.0]])
            wall.append(_face_towards((-side, 0, 0), panel, shade()))
        outer_x = side * (half + 2.5)
        front = np.array([[x, 0, -1.0], [x, high, -1.0], [outer_x, high, -1.0], [outer_x, 0, -1.0]])
        wall.append(_face_towards((0, 0, -1), front, shade()))
        middle = np.array([x, 2.0, depth * 0.55])
        things.append(Body(Mesh(wall), origin, right, forward, large=True, sorting=middle, shades=False))
        inner, outer = origin + right * side * (half + 2.0), origin + right * side * 60
        crest = UP * (clear + tall)
        top = [inner + crest + forward * 2, outer + crest + forward * 2]
        corners = np.stack([*top, outer - forward * 9, inner - forward * 5])
        things.append(_plate_towards(UP, corners, grass))
    return things
