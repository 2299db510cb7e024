"""Training crops of the network: square crops of scenes, moved, scaled, mirrored and with changed light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.deep.architecture import STRIDE
from tsr_engine.records import FloatArray, Picture

SIDE: Final = 256
"""Side of a crop, px."""
_SCALES = (0.65, 1.55)
_MIN_SIGN_PX = 12.0
"""Least width of a sign in the crop, px; narrower signs are ignored in training."""
_VISIBLE = 0.7
"""Least share of a sign in the crop; other signs are ignored in training."""
_MIN_SPREAD = 0.6
_SPREAD = 0.14
"""Standard deviation of a sign's target peak, as a share of its side; at least ``_MIN_SPREAD`` cells."""
_REGRESSED = 0.2
"""Height of the target peak from which cells predict the edges."""


@dataclass(frozen=True, slots=True)
class Crop:
    """One crop.

    Attributes:
        picture: shape (SIDE, SIDE, 3), BGR.
        boxes: signs to find, shape (n, 4), crop px.
        ignored: ignored signs, shape (m, 4), crop px.
        place: centre of the crop in the scene, px.
    """

    picture: Picture
    boxes: FloatArray
    ignored: FloatArray
    place: tuple[float, float]


class HardNegatives:
    """Places without signs to which the network gave the highest scores; they are trained on more often."""

    def __init__(self, most: int = 400) -> None:
        self.most = most
        self.places: list[tuple[float, int, float, float]] = []

    def add(self, score: float, scene: int, x: float, y: float) -> None:
        """Add a place; if the list is full, the place with the lowest score is dropped."""
        self.places.append((float(score), int(scene), float(x), float(y)))  # a state holds no NumPy types
        self.places.sort(reverse=True)
        del self.places[self.most :]

    def pop(self, rng: np.random.Generator) -> tuple[int, float, float] | None:
        """Remove a random place, which the caller adds again with its new score; None: there are none."""
        if not self.places:
            return None
        _, scene, x, y = self.places.pop(int(rng.integers(len(self.places))))
        return scene, x, y


def on_sign(rng: np.random.Generator, box: FloatArray) -> tuple[float, float, float]:
    """Scale and centre of a crop with the sign at a random place inside."""
    scale = float(np.exp(rng.uniform(*np.log(_SCALES))))
    side = float(max(box[2:] - box[:2]))
    scale = min(scale, 0.8 * SIDE / side)
    room = (SIDE / scale - side) / 2
    x, y = (box[:2] + box[2:]) / 2 + rng.uniform(-room, room, 2)
    return scale, float(x), float(y)


def background(
    rng: np.random.Generator, width: int, height: int, at: tuple[float, float] | None
) -> tuple[float, float, float]:
    """Scale and centre of a crop at a random place, or around a given one."""
    scale = float(np.exp(rng.uniform(*np.log(_SCALES))))
    half = SIDE / scale / 2
    if at is None:
        x, y = rng.uniform(half, max(half + 1, width - half)), rng.uniform(half, max(half + 1, height - half))
    else:
        x, y = np.array(at) + rng.uniform(-0.6, 0.6, 2) * half
    return scale, float(x), float(y)


def cut(rng: np.random.Generator, scene: Picture, boxes: FloatArray, scale: float, x: float, y: float) -> Crop:
    """Cut out a crop, mirror it at random, and change its light."""
    mirrored = rng.random() < 0.5
    along = -scale if mirrored else scale
    centre = SIDE / 2
    warp = np.array([[along, 0.0, centre - along * x], [0.0, scale, centre - scale * y]])
    # The warp uses pixel centres, boxes use pixel edges.
    warp[:, 2] += 0.5 * (warp[:, :2].sum(axis=1) - 1)
    picture = cv2.warpAffine(scene, warp, (SIDE, SIDE), flags=cv2.INTER_LINEAR, borderValue=(114,) * 3)
    moved = (boxes.reshape(-1, 2, 2) - (x, y)) * (along, scale) + centre
    moved = np.concatenate([moved.min(axis=1), moved.max(axis=1)], axis=1)
    inside = np.clip(moved, 0, SIDE)
    share = _areas(inside) / np.maximum(1e-9, _areas(moved))
    trained = (share >= _VISIBLE) & ((moved[:, 2:] - moved[:, :2]).min(axis=1) >= _MIN_SIGN_PX)
    return Crop(_relit(rng, picture), moved[trained], inside[~trained & (share > 0)], (x, y))


def _areas(boxes: FloatArray) -> FloatArray:
    return np.asarray(np.prod(boxes[:, 2:] - boxes[:, :2], axis=1))


def _relit(rng: np.random.Generator, picture: Picture) -> Picture:
    gain = np.exp(rng.uniform(-0.35, 0.35)) * np.exp(rng.uniform(-0.06, 0.06, 3))
    lift = rng.uniform(-18, 18)
    lit = picture * gain.astype(np.float32) + np.float32(lift)
    if rng.random() < 0.3:
        grey = lit.mean(axis=2, keepdims=True)
        lit = grey + (lit - grey) * np.float32(rng.uniform(0.4, 1.3))
    if rng.random() < 0.25:
        lit = cv2.GaussianBlur(lit, (0, 0), float(rng.uniform(0.4, 1.1)))
    return np.asarray(np.clip(lit, 0, 255), np.uint8)


def targets(crop: Crop) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """The network's target outputs for a crop.

    Returns:
        ``heatmap``, shape (cells, cells): 1 at the cell of a sign's centre, lower around it, -1 in ignored cells;
        ``edges``, shape (4, cells, cells): left, top, right and bottom edge of the cell's sign, crop px; ``weights``,
        shape (cells, cells): weights of the edges.
    """
    cells = SIDE // STRIDE
    centres: FloatArray = (np.arange(cells, dtype=np.float64) + 0.5) * STRIDE
    heatmap = np.zeros((cells, cells), np.float32)
    edges = np.zeros((4, cells, cells), np.float32)
    for box in crop.ignored:
        heatmap[np.ix_(_within(centres, box[1], box[3]), _within(centres, box[0], box[2]))] = -1
    for box in sorted(crop.boxes, key=lambda b: -float(np.prod(b[2:] - b[:2]))):  # small ones over large ones
        (cx, cy), side = (box[:2] + box[2:]) / 2, box[2:] - box[:2]
        spread = np.maximum(_MIN_SPREAD * STRIDE, _SPREAD * side)
        peak = np.exp(-(((centres - cy) / spread[1]) ** 2)[:, None] / 2 - (((centres - cx) / spread[0]) ** 2)[None] / 2)
        row, column = (int(np.clip(v // STRIDE, 0, cells - 1)) for v in (cy, cx))
        peak[row, column] = 1.0
        higher = peak > np.maximum(heatmap, 0.02)
        heatmap[higher] = peak[higher]
        edges[:, higher] = box[:, None]
    weights = np.where(heatmap >= _REGRESSED, heatmap, 0).astype(np.float32)
    return heatmap, edges, weights


def _within(centres: FloatArray, low: float, high: float) -> NDArray[np.bool_]:
    return (centres > low - STRIDE / 2) & (centres < high + STRIDE / 2)
