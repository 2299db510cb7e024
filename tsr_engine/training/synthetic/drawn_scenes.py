"""Pastes drawn signs into scenes, for signs that no annotated scene has.

Drawings of the label set ``vienna`` are rotated, faded and lit like their surroundings. They are
used only for training, never for figures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from tsr_engine.geometry.boxes import iou
from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.labels.classes import default_keys
from tsr_engine.labels.files import VIENNA, shipped_set
from tsr_engine.pictograms import draw, names
from tsr_engine.records import FloatArray, Picture

__all__ = ["COMMON", "OTHER_BOARDS", "DrawnScenesPlan", "drawn_keys", "drawn_scenes", "paste", "turned"]

COMMON: Final = (
    "no-stopping", "no-parking", "parking", "pedestrian-crossing", "one-way", "one-way-to-the-right",
    "one-way-to-the-left", "bus-stop", "motorway", "end-of-motorway", "no-through-road", "residential-area",
    "end-of-residential-area", "speed-limit-zone-30", "end-of-speed-limit-zone-30", "no-parking-zone",
    "parking-on-the-footway", "cycle-track", "footpath", "shared-path", "turn-right-here", "turn-left-here",
)  # fmt: skip
"""The most common labels on roads."""
_KNOWN, _COMMON = 0.2, 0.5
"""Shares of drawn signs that are among the 43 of GTSRB, and among the common ones; the rest are other labels."""
_YELLOW: Final = 0.12
"""Share of signs with yellow in place of white."""
OTHER_BOARDS: Final = frozenset({"built-up-area", "end-of-built-up-area", "place-name", "end-of-place-name"})
"""Boards whose drawing is only text."""
_DRAWN: Final = 192
"""Side at which a sign is drawn before it is reduced, px."""


@dataclass(frozen=True, slots=True)
class DrawnScenesPlan:
    """Numbers and appearance of drawn signs.

    Attributes:
        scenes: number of scenes.
        each: signs per scene; fewer if there is no room.
        smallest: least mean side of a sign, px.
        largest: largest mean side of a sign, px. The logarithm of sides is uniform in between.
        turn: standard deviation of the rotation, degrees.
        squeeze: largest share of its width that a sign loses when it faces sideways.
        below: share of signs with another one below.
    """

    scenes: int = 100
    each: int = 8
    smallest: float = 16.0
    largest: float = 100.0
    turn: float = 3.0
    squeeze: float = 0.3
    below: float = 0.3


def drawn_keys() -> tuple[str, ...]:
    """Labels drawn in addition to the 43 of GTSRB: discs and rectangles of ``vienna``, without boards and plates."""
    known, drawn = set(default_keys()), set(names())
    return tuple(
        label.key
        for label in shipped_set(VIENNA)
        if label.key not in known | OTHER_BOARDS
        and label.shape in ("circle", "rectangle")
        and label.category not in ("direction", "additional")
        and f"{VIENNA}/{label.key}" in drawn
    )


def drawn_scenes(scenes: Sequence[Scene], plan: DrawnScenesPlan, folder: Path, rng: np.random.Generator) -> list[Scene]:
    """Write scenes with drawn signs to a folder as pictures.

    Args:
        scenes: the scenes to draw on.
        plan: see :class:`DrawnScenesPlan`.
        folder: an existing folder for the pictures.
        rng: source of all randomness.

    Returns:
        Scenes with only the drawn signs, by their ids in ``vienna``; the original signs are ignored regions.
    """
    ids = {label.key: label.id for label in shipped_set(VIENNA)}
    known = default_keys()
    drawings = {key: f"gtsrb/{number}" for number, key in enumerate(known)}
    drawings |= {key: f"{VIENNA}/{key}" for key in drawn_keys()}
    groups = (known, [key for key in COMMON if key in drawings], drawn_keys())
    out = []
    for number in range(plan.scenes):
        ground = scenes[int(rng.integers(len(scenes)))]
        picture = read_picture(ground.path)
        boxes: list[FloatArray] = []
        labels: list[int] = []
        for _ in range(plan.each):
            place = None
            for _ in range(2 if rng.random() < plan.below else 1):
                key = str(rng.choice(groups[rng.choice(3, p=(_KNOWN, _COMMON, 1 - _KNOWN - _COMMON))]))
                sign = turned(draw(drawings[key], _DRAWN), plan, rng)
                box = _placed(sign, picture, place, plan, rng)
                if _free(box, [*boxes, *ground.occupied], picture):
                    paste(picture, sign, box, rng)
                    boxes.append(box)
                    labels.append(ids[key])
                    place = box
        path = folder / f"{number:05d}.jpg"
        cv2.imwrite(str(path), picture, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(60, 96))])
        out.append(Scene(path.name, path, np.array(boxes).reshape(-1, 4), np.array(labels, np.int64), ground.occupied))
    return out


def turned(drawing: Picture, plan: DrawnScenesPlan, rng: np.random.Generator) -> Picture:
    """Change a drawing (BGRA) as a camera may see it: rotated, squeezed, in other paint; cropped to its silhouette."""
    side = drawing.shape[0]
    squeeze = 1.0 - plan.squeeze * rng.random() ** 2
    angle = np.deg2rad(np.clip(rng.normal(0, plan.turn), -3 * plan.turn, 3 * plan.turn))
    cos, sin = np.cos(angle), np.sin(angle)
    linear = np.array([[cos, -sin], [sin, cos]]) @ np.diag([squeeze, 1.0])
    middle = np.array([side / 2, side / 2])
    wide = round(1.2 * side)
    shift = np.array([wide / 2, wide / 2]) - linear @ middle
    whole = cv2.warpAffine(drawing, np.column_stack([linear, shift]), (wide, wide), flags=cv2.INTER_LINEAR)
    seen = whole[..., 3] > 64
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    cut = np.asarray(whole[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]).copy()
    if rng.random() < _YELLOW:
        white = cut[..., :3].min(axis=2) > 180
        cut[white, 0] = rng.uniform(0, 110)
        cut[white, 1] = rng.uniform(150, 220)
    hsv = cv2.cvtColor(cut[..., :3], cv2.COLOR_BGR2HSV).astype(np.float32)
    hsv[..., 0] = (hsv[..., 0] + rng.normal(0, 4)) % 180
    hsv[..., 1] *= rng.uniform(0.55, 1.05)
    hsv[..., 2] = 255 * (hsv[..., 2] / 255) ** rng.uniform(0.7, 1.3)
    cut[..., :3] = cv2.cvtColor(np.clip(hsv, 0, 255).astype(np.uint8), cv2.COLOR_HSV2BGR)
    return cut


def _placed(
    sign: Picture, picture: Picture, above: FloatArray | None, plan: DrawnScenesPlan, rng: np.random.Generator
) -> FloatArray:
    """Choose the place of a sign: between sky and road, or directly below another sign."""
    height, width = sign.shape[:2]
    side = float(np.exp(rng.uniform(np.log(plan.smallest), np.log(plan.largest))))
    scale = side / np.sqrt(height * width)
    if above is not None:
        scale = (above[2] - above[0]) / width * rng.uniform(0.85, 1.15)
    w, h = max(4, round(width * scale)), max(4, round(height * scale))
    if above is None:
        x = int(rng.integers(0, max(1, picture.shape[1] - w)))
        y = int(rng.uniform(0.2, 0.75) * picture.shape[0])
    else:
        x = round((above[0] + above[2] - w) / 2)
        y = int(np.ceil(above[3])) + int(rng.integers(0, 3))
    return np.array([x, y, x + w, y + h], np.float64)


def _free(box: FloatArray, others: Sequence[FloatArray], picture: Picture) -> bool:
    inside = box[0] >= 0 and box[1] >= 0 and box[2] <= picture.shape[1] and box[3] <= picture.shape[0]
    return bool(inside and (not len(others) or iou(box[None], np.array(others)).max() == 0))


def paste(picture: Picture, sign: Picture, box: FloatArray, rng: np.random.Generator) -> None:
    """Paste a sign into a picture, lit like its surroundings and blurred like a lens, mostly on a pole."""
    x1, y1, x2, y2 = box.astype(int)
    reach = max(6, (x2 - x1) // 2)
    top, left = max(0, y1 - reach), max(0, x1 - reach)
    part = picture[top : y2 + reach, left : x2 + reach]
    ground = part.astype(np.float32)
    shown = sign.astype(np.float32)
    shown[..., :3] *= shown[..., 3:] / 255  # transparent pixels have a colour too
    small = cv2.resize(shown, (x2 - x1, y2 - y1), interpolation=cv2.INTER_AREA)
    layer = np.zeros((*part.shape[:2], 4), np.float32)
    layer[y1 - top : y2 - top, x1 - left : x2 - left] = small
    mean = ground.reshape(-1, 3).mean(axis=0)
    white = np.clip(mean.mean() * rng.uniform(0.9, 2.4), 45, 250)
    cast = 1 + 0.4 * (mean / max(1.0, float(mean.mean())) - 1)
    if rng.random() < 0.7:  # the pole
        thick = max(1, round((x2 - x1) * rng.uniform(0.05, 0.13)))
        start = (x1 + x2 - thick) // 2 - left
        ground[y2 - top :, start : start + thick] = white * rng.uniform(0.2, 0.8)
    layer = cv2.GaussianBlur(layer, (0, 0), float(rng.uniform(0.35, 0.9)))
    alpha = layer[..., 3:] / 255
    face = layer[..., :3] * (white / 255) * cast
    face += white * rng.uniform(0.0, 0.12) * alpha  # black paint reflects too
    mixed = face + ground * (1 - alpha)
    picture[top : y2 + reach, left : x2 + reach] = np.clip(mixed, 0, 255).astype(np.uint8)
