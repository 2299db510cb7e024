"""Collects the crops for the network's training: GTSRB's, and drawings of all signs of ``vienna`` in other styles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.labels.classes import default_keys
from tsr_engine.labels.files import VIENNA, shipped_set
from tsr_engine.pictograms import draw, names
from tsr_engine.records import Picture
from tsr_engine.training.synthetic.classifier_augmentation import MAX_CROP_PX, LoadedCrop
from tsr_engine.training.synthetic.drawn_scenes import OTHER_BOARDS, DrawnScenesPlan, paste, turned
from tsr_engine.training.synthetic.drawn_signs import SUPERSAMPLING, drawn_crops, ground
from tsr_engine.training.synthetic.inset_signs import inset_crops

__all__ = ["SIDE", "CropBank", "bank_of", "drawn_labels", "network_keys"]

SIDE: Final = 72
"""Side of stored crops, px."""
_DRAWN: Final = 192
"""Side at which a sign is drawn before it is reduced, px."""
_GROUND: Final = 24
"""Side of a drawn crop before it is enlarged by ``SUPERSAMPLING``, px: one and a half times the sign's side."""
_EACH: Final = 60
"""Drawn crops per label, and crops with smaller digits per limit."""
_EACH_LIMIT: Final = 120
"""Further drawn crops per limit and arrow."""
_SHARES: Final = {"limits and arrows": 0.05, "inset": 0.05, "known": 0.06, "other": 0.10}
"""Shares of the views; the rest are of real crops."""
_BALANCE: Final = 0.6
"""Exponent of class sizes in the draw of real crops: 1: proportional, 0: all classes equally often."""
_BENT_REAL: Final = 0.02
"""Strength by which views bend the drawing inside a real sign, as a share of its side."""
_BENT_INSET: Final = 0.03
_BENT_DRAWN: Final = 0.07
_SAME_SIGN: Final = {"pedestrian-crossing-ahead": "pedestrians"}
"""Labels that are another country's version of one of the 43."""


@dataclass(frozen=True, slots=True)
class CropBank:
    """Crops of one size.

    Attributes:
        pixels: shape (n, SIDE, SIDE, 3), uint8, BGR.
        boxes: shape (n, 4), the signs, as shares of the crop's side.
        classes: shape (n,), indices in ``network_keys()``.
        bends: shape (n,), see :func:`~tsr_engine.training.synthetic.network_augmentation.views`.
        chances: shape (n,), probability of each crop; sums to 1.
    """

    pixels: NDArray[np.uint8]
    boxes: NDArray[np.float32]
    classes: NDArray[np.int64]
    bends: NDArray[np.float32]
    chances: NDArray[np.float64]


def network_keys() -> tuple[str, ...]:
    """Labels that the network distinguishes: the 43 of GTSRB, then those of ``vienna`` with a drawing."""
    known, drawn = default_keys(), set(names())
    return (
        *known,
        *(
            label.key
            for label in shipped_set(VIENNA)
            if label.key not in {*known, *OTHER_BOARDS, *_SAME_SIGN}
            and label.category not in ("direction", "additional")
            and f"{VIENNA}/{label.key}" in drawn
        ),
    )


def drawn_labels(generator: np.random.Generator) -> list[LoadedCrop]:
    """Drawings of all labels, faded, rotated and lit, on random grounds; ``class_id`` indexes ``network_keys()``."""
    keys = network_keys()
    drawings = [(number, f"gtsrb/{number}") for number in range(len(default_keys()))]
    drawings += [(number, f"{VIENNA}/{key}") for number, key in enumerate(keys) if number >= len(drawings)]
    drawings += [(keys.index(key), f"{VIENNA}/{other}") for other, key in _SAME_SIGN.items()]
    pictures = [(number, draw(name, _DRAWN)) for number, name in drawings]
    return [_drawn(picture, number, generator) for number, picture in pictures for _ in range(_EACH)]


def _drawn(drawing: Picture, class_id: int, generator: np.random.Generator) -> LoadedCrop:
    sign = turned(drawing, DrawnScenesPlan(), generator)
    height, width = sign.shape[:2]
    scale = MAX_CROP_PX / max(height, width)
    w, h = round(width * scale), round(height * scale)
    side = _GROUND * SUPERSAMPLING
    left, top = (side - w) // 2, (side - h) // 2
    box = np.array([left, top, left + w, top + h], np.float64)
    pixels = ground(_GROUND, generator)
    paste(pixels, sign, box, generator)
    return LoadedCrop(pixels, box, class_id)


def bank_of(crops: Sequence[LoadedCrop], seed: int) -> CropBank:
    """Real crops, the same with smaller digits, and drawn crops, all of one size.

    Args:
        crops: real crops with GTSRB classes.
        seed: seed of all draws.
    """
    generator = np.random.default_rng([seed, 5])
    labels = drawn_labels(generator)
    known = len(default_keys())
    groups = {
        "limits and arrows": (drawn_crops(_EACH_LIMIT, generator), _BENT_DRAWN),
        "inset": (inset_crops(crops, _EACH, generator), _BENT_INSET),
        "known": ([crop for crop in labels if crop.class_id < known], _BENT_DRAWN),
        "other": ([crop for crop in labels if crop.class_id >= known], _BENT_DRAWN),
    }
    real = np.array([crop.class_id for crop in crops])
    weight = np.bincount(real, minlength=known)[real] ** (_BALANCE - 1.0)
    chances = [(1 - sum(_SHARES.values())) * weight / weight.sum()]
    bends = [np.full(len(crops), _BENT_REAL)]
    every = list(crops)
    for name, (group, bend) in groups.items():
        chances.append(np.full(len(group), _SHARES[name] / len(group)))
        bends.append(np.full(len(group), bend))
        every += group
    return CropBank(
        np.stack([cv2.resize(crop.pixels, (SIDE, SIDE), interpolation=_interpolation(crop)) for crop in every]),
        np.stack([crop.box / np.tile(crop.pixels.shape[1::-1], 2) for crop in every]).astype(np.float32),
        np.array([crop.class_id for crop in every]),
        np.concatenate(bends).astype(np.float32),
        np.concatenate(chances),
    )


def _interpolation(crop: LoadedCrop) -> int:
    return cv2.INTER_AREA if min(crop.pixels.shape[:2]) > SIDE else cv2.INTER_LINEAR
