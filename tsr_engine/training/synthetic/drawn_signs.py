"""Draws signs in other countries' styles for the classifier's training: other type faces, other arrows.

GTSRB holds German signs only. The Vienna Convention (1968, annex 1, C14 and D1) leaves the type face of a limit and the
form of an arrow to each country: thin or wide digits, a straight arrow where Germany bends it. Drawn crops
are used only for training, never for figures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.recognition.descriptor import MARGIN
from tsr_engine.records import Picture
from tsr_engine.training.synthetic.classifier_augmentation import MAX_CROP_PX, LoadedCrop
from tsr_engine.training.synthetic.drawn_digits import stroked_digits

__all__ = [
    "DRAWN_CLASSES",
    "EMPTY",
    "LIMITS",
    "PRINTED",
    "ROAD",
    "SUPERSAMPLING",
    "Lettering",
    "drawn_crop",
    "drawn_crops",
    "ground",
]

LIMITS: Final = {0: "20", 1: "30", 2: "50", 3: "60", 4: "70", 5: "80", 7: "100", 8: "120"}
"""Class of GTSRB -> the limit in its red ring, km/h."""
EMPTY: Final = 15
"""Class of *no vehicles*: the ring alone."""
_ARROWS: Final = {33: 0.0, 34: 180.0, 35: -90.0, 38: 45.0, 39: 135.0}
"""Class -> direction of its arrow, degrees clockwise from the right."""
SUPERSAMPLING: Final = 4
"""Signs are drawn larger by this factor and then reduced, which smooths their edges."""
_Ink = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Lettering:
    """Type faces of the digits on drawn limits.

    Attributes:
        stroked: share drawn as strokes in a random face (:mod:`~.drawn_digits`).
        built_in: share of the rest in OpenCV's own face, in any weight; the others are outlines of ``faces``.
        faces: type face families shipped with matplotlib.
    """

    stroked: float
    built_in: float
    faces: tuple[str, ...]


PRINTED: Final = Lettering(0.0, 0.5, ("DejaVu Sans", "DejaVu Sans Mono", "DejaVu Serif", "STIXGeneral", "cmss10"))
"""Printed type faces, which suffice to detect a limit: the sign verifier is trained on them."""
ROAD: Final = Lettering(0.6, 0.25, ("DejaVu Sans", "DejaVu Sans Mono", "cmss10"))
"""Type faces of road authorities, for reading the number."""


def drawn_crop(class_id: int, rng: np.random.Generator, lettering: Lettering = ROAD) -> LoadedCrop:
    """Draw a sign of a class in a random foreign style on a random ground, ``MAX_CROP_PX`` px wide.

    Args:
        class_id: one of ``DRAWN_CLASSES``, or ``EMPTY``.
        rng: source of the drawing.
        lettering: type faces of limits.

    Raises:
        ValueError: the class has no drawing.
    """
    if class_id not in (*DRAWN_CLASSES, EMPTY):
        raise ValueError(f"class_id must be one of {(*DRAWN_CLASSES, EMPTY)}. Got {class_id} instead.")
    margin = round(MARGIN * MAX_CROP_PX) + 4
    side = MAX_CROP_PX + 2 * margin
    canvas = ground(side, rng)
    centre, radius = side * SUPERSAMPLING / 2, MAX_CROP_PX * SUPERSAMPLING / 2
    if class_id in LIMITS or class_id == EMPTY:
        _limit(LIMITS.get(class_id, ""), lettering, canvas, centre, radius, rng)
    else:
        _arrow(_ARROWS[class_id], canvas, centre, radius, rng)
    pixels = cv2.resize(canvas, (side, side), interpolation=cv2.INTER_AREA)
    light = np.float32(rng.uniform(0.35, 1.0))
    pixels = np.clip(pixels.astype(np.float32) * light, 0, 255).astype(np.uint8)
    box = np.array([margin, margin, margin + MAX_CROP_PX, margin + MAX_CROP_PX], np.float64)
    return LoadedCrop(np.asarray(pixels, dtype=np.uint8), box, class_id)


def ground(side: int, rng: np.random.Generator) -> Picture:
    """Sky, leaves or wall: a coarse random texture about a random colour."""
    colour = rng.uniform(40, 220, 3)
    coarse = rng.normal(0, rng.uniform(2, 45), (int(rng.integers(3, 14)), int(rng.integers(3, 14)), 1))
    coarse = coarse + rng.normal(0, 8, (*coarse.shape[:2], 3))
    texture = cv2.resize(
        (coarse + colour).astype(np.float32), (side * SUPERSAMPLING,) * 2, interpolation=cv2.INTER_CUBIC
    )
    return np.asarray(np.clip(texture, 0, 255), dtype=np.uint8)


def _ink(blue: float, green: float, red: float, rng: np.random.Generator) -> _Ink:
    """A paint's colour with random fading and tint."""
    fade = rng.uniform(0.0, 0.3)
    paint = np.array([blue, green, red]) * (1 - fade) + 128 * fade + rng.normal(0, 8, 3)
    b, g, r = np.clip(paint, 0, 255).tolist()
    return b, g, r


def _disc(canvas: Picture, centre: float, radius: float, ink: _Ink) -> None:
    cv2.circle(canvas, (round(centre * 16), round(centre * 16)), round(radius * 16), ink, -1, cv2.LINE_AA, 4)


def _limit(
    text: str, lettering: Lettering, canvas: Picture, centre: float, radius: float, rng: np.random.Generator
) -> None:
    """C14: a red ring, a white or yellow field, black digits; without text C2, the bare ring."""
    if rng.random() < 0.3:
        _disc(canvas, centre, radius, _ink(235, 235, 235, rng))
        radius *= rng.uniform(0.94, 0.99)
        inner = radius * rng.uniform(0.72, 0.86)
    else:
        inner = radius * rng.uniform(0.74, 0.88)
    _disc(canvas, centre, radius, _ink(40, 30, 190, rng))
    field = _ink(90, 215, 235, rng) if rng.random() < 0.12 else _ink(235, 235, 235, rng)
    _disc(canvas, centre, inner, field)
    if not text:
        return
    mask = _digits(text, lettering, rng)
    height = inner * rng.uniform(0.75, 1.05)
    width = min(height * mask.shape[1] / mask.shape[0] * rng.uniform(0.8, 1.15), 1.72 * inner)
    size = (max(8, round(width)), max(8, round(height)))
    _stamp(canvas, cv2.resize(mask, size, interpolation=cv2.INTER_AREA), centre, centre, _ink(30, 30, 30, rng))


def _digits(text: str, lettering: Lettering, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Digits as a mask cut to their ink, about 120 px high."""
    kind = rng.random()
    if kind < lettering.stroked:
        mask = stroked_digits(text, rng)
    elif kind < lettering.stroked + lettering.built_in:
        mask = np.zeros((320, 900), np.uint8)
        # the built-in face has a slashed zero; the letter O looks like the zero of road signs
        glyphs, weight = text.replace("0", "O"), int(rng.integers(200, 900))
        cv2.putText(mask, glyphs, (60, 220), 255, cv2.FontFace("sans"), 150, weight)
    else:
        mask = _outlined(text, lettering.faces, rng)
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return np.ascontiguousarray(mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1])


def _outlined(text: str, faces: tuple[str, ...], rng: np.random.Generator) -> NDArray[np.uint8]:
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    family, bold = faces[int(rng.integers(len(faces)))], rng.random() < 0.5
    face = FontProperties(family=family, weight="bold" if bold and family != "cmss10" else "normal")
    mask = np.zeros((320, 900), np.uint8)
    outlines = [
        np.round((np.array([60.0, 220.0]) + points * np.array([1.0, -1.0])) * 16).astype(np.int32)
        for points in TextPath((0, 0), text, size=150, prop=face).to_polygons()
    ]
    cv2.fillPoly(mask, outlines, 255, cv2.LINE_AA, 4)
    return mask


def _stamp(canvas: Picture, mask: NDArray[np.generic], cx: float, cy: float, ink: _Ink) -> None:
    """Paint a mask centred at a point."""
    h, w = mask.shape
    y, x = round(cy - h / 2), round(cx - w / 2)
    part = canvas[y : y + h, x : x + w]
    cover = mask.astype(np.float32)[..., None] / 255
    part[:] = (part * (1 - cover) + np.array(ink, np.float32) * cover).astype(np.uint8)


def _arrow(degrees: float, canvas: Picture, centre: float, radius: float, rng: np.random.Generator) -> None:
    """D1a: a blue disc with a straight white arrow; 0 degrees point right, 90 down."""
    if rng.random() < 0.6:
        _disc(canvas, centre, radius, _ink(235, 235, 235, rng))
        radius *= rng.uniform(0.9, 0.98)
    _disc(canvas, centre, radius, _ink(165, 85, 15, rng))
    reach, shaft = rng.uniform(0.6, 0.82), rng.uniform(0.09, 0.19)
    head, neck = rng.uniform(0.3, 0.55), rng.uniform(0.25, 0.5)
    back = neck * rng.uniform(0.0, 0.4)  # arrowheads with swept-back wings
    upper = [(reach - neck, head), (reach - neck + back, shaft), (-reach, shaft)]
    points = np.array([(reach, 0), *upper, *((x, -y) for x, y in reversed(upper))])
    angle = math.radians(degrees + rng.uniform(-4, 4))
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    outline = np.round((centre + radius * points @ turn) * 16).astype(np.int32)
    cv2.fillPoly(canvas, [outline], _ink(235, 235, 235, rng), cv2.LINE_AA, 4)


def drawn_crops(each: int, generator: np.random.Generator, lettering: Lettering = ROAD) -> list[LoadedCrop]:
    """Drawn crops for one training, so many of each class that is drawn."""
    return [drawn_crop(class_id, generator, lettering) for class_id in DRAWN_CLASSES for _ in range(each)]


DRAWN_CLASSES: Final = tuple(sorted({**LIMITS, **_ARROWS}))
"""GTSRB classes with drawings: limits and straight arrows."""
