"""Scenes with drawn signs, for systems that are trained in a test."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from tsr_engine.io.gtsdb import Scene

SIZE = (220, 160)


def drawn_scenes(folder: Path, count: int) -> list[Scene]:
    """Scenes of 220 x 160 px on a noisy ground, each with a red, a blue and a yellow sign of 30 to 40 px."""
    rng = np.random.default_rng(5)
    out = []
    for number in range(count):
        ground = rng.integers(60, 130, (40, 55, 1)).repeat(3, axis=2).astype(np.uint8)
        picture = np.ascontiguousarray(cv2.resize(ground, SIZE, interpolation=cv2.INTER_CUBIC))
        boxes = []
        for index, draw in enumerate((_red, _blue, _yellow)):
            radius = int(rng.integers(15, 21))
            x, y = int(36 + 72 * index + rng.integers(-8, 9)), int(rng.integers(40, 120))
            draw(picture, x, y, radius)
            boxes.append((x - radius, y - radius, x + radius + 1, y + radius + 1))
        grain = rng.normal(0, 4, picture.shape)
        picture = np.clip(picture + grain, 0, 255).astype(np.uint8)
        path = folder / f"{number:05d}.png"
        cv2.imwrite(str(path), picture)
        out.append(Scene(path.name, path, np.array(boxes, float), np.array([1, 38, 12])))
    return out


def _red(picture: np.ndarray, x: int, y: int, r: int) -> None:
    cv2.circle(picture, (x, y), r, (40, 30, 190), -1)
    cv2.circle(picture, (x, y), round(0.7 * r), (235, 235, 235), -1)


def _blue(picture: np.ndarray, x: int, y: int, r: int) -> None:
    cv2.circle(picture, (x, y), r, (170, 80, 20), -1)
    cv2.arrowedLine(picture, (x - r // 2, y - r // 2), (x + r // 2, y + r // 2), (240, 240, 240), 3)


def _yellow(picture: np.ndarray, x: int, y: int, r: int) -> None:
    for side, colour in ((r, (235, 235, 235)), (round(0.75 * r), (20, 180, 230))):
        cv2.fillPoly(picture, [np.array([(x, y - side), (x + side, y), (x, y + side), (x - side, y)])], colour)
