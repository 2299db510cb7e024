"""Synthetic drives: a drawn sign approaches in front of a textured plane, with its exact boxes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from tsr_engine.follow import Pictures
from tsr_engine.records import FloatArray, Picture

WIDTH, HEIGHT = 480, 320
MARGIN = 260
"""The scene is larger than the picture by this on each side."""


@dataclass(frozen=True)
class Frame:
    picture: Picture
    corrupt: bool = False


@dataclass(frozen=True)
class Drive:
    pictures: list[Picture]
    boxes: dict[int, FloatArray]

    def source(self, requested: list[int] | None = None, corrupt: Sequence[int] = ()) -> Pictures:
        def give(k: int) -> Frame | None:
            if requested is not None:
                requested.append(k)
            return Frame(self.pictures[k], k in corrupt) if 0 <= k < len(self.pictures) else None

        return give


def draw_board(seed: int, side: int = 200) -> Picture:
    """A board with a rim and a few patches, unlike any sign of the label set."""
    rng = np.random.default_rng(seed)
    picture = np.full((side, side, 3), (230, 225, 220), np.uint8)
    for _ in range(5):
        x, y = rng.integers(30, side - 70, 2)
        w, h = rng.integers(25, 60, 2)
        colour = tuple(int(c) for c in rng.integers(0, 160, 3))
        cv2.rectangle(picture, (int(x), int(y)), (int(x + w), int(y + h)), colour, -1)
    cv2.rectangle(picture, (6, 6), (side - 7, side - 7), (40, 40, 160), 12)
    return picture


@cache
def draw_backdrop(seed: int) -> Picture:
    rng = np.random.default_rng(seed)
    picture = np.full((HEIGHT + 2 * MARGIN, WIDTH + 2 * MARGIN, 3), 110, np.uint8)
    for _ in range(500):
        x, y = rng.integers(0, [WIDTH + 2 * MARGIN, HEIGHT + 2 * MARGIN])
        w, h = rng.integers(6, 50, 2)
        colour = tuple(int(c) for c in rng.integers(20, 210, 3))
        cv2.rectangle(picture, (int(x), int(y)), (int(x + w), int(y + h)), colour, -1)
    return cv2.GaussianBlur(picture, (0, 0), 1.2)


def make_drive(
    frames: int = 40,
    first: float = 14.0,
    last: float = 60.0,
    seed: int = 1,
    at: tuple[float, float] = (18.0, -9.0),
    gain: Callable[[int], float] = lambda k: 1.0,
    shift: Callable[[int], tuple[float, float]] = lambda k: (0.0, 0.0),
) -> Drive:
    """An approach at constant speed.

    Args:
        frames: number of frames.
        first: side of the board in the first frame, px.
        last: side of the board in the last frame, px.
        seed: of board and scene.
        at: of the board's centre from the focus of expansion in the first frame, px.
        gain: of light by frame.
        shift: of the camera by frame, px.
    """
    scene, board = draw_backdrop(seed), draw_board(seed)
    rng = np.random.default_rng(seed)
    grain = rng.normal(0.0, 1.5, (HEIGHT, WIDTH, 3)).astype(np.float32)
    pictures, boxes = [], {}
    for k in range(frames):
        side = 1.0 / (1.0 / first + (1.0 / last - 1.0 / first) * k / max(frames - 1, 1))
        zoom = side / first
        dx, dy = shift(k)
        # the scene is far away: it grows a fifth as fast
        far = 1.0 + 0.2 * (zoom - 1.0)
        cx, cy = WIDTH / 2 + dx, HEIGHT / 2 + dy
        middle = np.array([scene.shape[1] / 2, scene.shape[0] / 2])
        matrix = np.array([[far, 0, cx - far * middle[0]], [0, far, cy - far * middle[1]]])
        picture = cv2.warpAffine(scene, matrix, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR)
        x, y = cx + at[0] * zoom, cy + at[1] * zoom
        picture = paste_board(picture, board, np.array([x - side / 2, y - side / 2, x + side / 2, y + side / 2]))
        noise = np.roll(grain, int(rng.integers(grain.size)))
        pictures.append(np.clip(picture * np.float32(gain(k)) + noise, 0, 255).astype(np.uint8))
        boxes[k] = np.array([x - side / 2, y - side / 2, x + side / 2, y + side / 2])
    return Drive(pictures, boxes)


def paste_board(picture: Picture, board: Picture, box: FloatArray) -> Picture:
    """Paste the board into a box with subpixel position."""
    scale = (box[2] - box[0]) / board.shape[1]
    matrix = np.array([[scale, 0, box[0] + 0.5 * scale - 0.5], [0, scale, box[1] + 0.5 * scale - 0.5]])
    small = cv2.GaussianBlur(board, (0, 0), max(0.4 / scale, 0.1))
    size = (picture.shape[1], picture.shape[0])
    over = cv2.warpAffine(small, matrix, size, flags=cv2.INTER_LINEAR)
    mask = cv2.warpAffine(np.ones(board.shape[:2], np.float32), matrix, size, flags=cv2.INTER_LINEAR)[..., None]
    return np.asarray(picture * (1 - mask) + over * mask, dtype=np.uint8)


def cover_box(picture: Picture, box: FloatArray) -> Picture:
    """The picture with a grey block over a box."""
    out = picture.copy()
    x1, y1, x2, _ = (int(v) for v in box)
    cv2.rectangle(out, (x1 - 6, max(0, y1 - 8)), (x2 + 6, HEIGHT), (90, 100, 95), -1)
    return out
