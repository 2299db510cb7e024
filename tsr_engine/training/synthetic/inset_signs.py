"""Makes speed limits with smaller digits than Germany's from real crops, for the classifier's training.

The Vienna Convention (1968, annex 1, C14) leaves the height of a limit's digits to each country. In Germany they fill
the field; elsewhere they take little more than half of it. A classifier that has seen only German ones takes such
digits for distant or other ones. A real crop keeps the light, noise and blur of a camera, which drawings lack: its
middle is shrunk, the field between digits and ring is widened, and the ring stays in place.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.training.synthetic.classifier_augmentation import LoadedCrop
from tsr_engine.training.synthetic.drawn_signs import LIMITS

__all__ = ["INSET_CLASSES", "inset_crop", "inset_crops"]

INSET_CLASSES: Final = tuple(LIMITS)
"""GTSRB classes with a limit in a red ring."""

_DIGITS: Final = 0.63
"""Radius that contains a German limit's digits, except for corners of three digits, as a share of the sign's."""
_FIELD, _RING = 0.67, 0.75
"""Outer radius of the white field, and inner radius of the part that is only red ring."""
_SMALLEST, _LARGEST = 0.62, 0.92
"""Size of the digits relative to the original."""
_RING_FROM, _RING_TO = 0.70, 0.82
"""Inner radius of the new ring."""
_EDGE: Final = 0.05
"""Width of the transition between field and ring."""


def inset_crop(crop: LoadedCrop, rng: np.random.Generator) -> LoadedCrop:
    """Shrink the digits of a limit towards the middle, and widen or narrow its ring.

    Args:
        crop: crop of one of ``INSET_CLASSES``.
        rng: source of the sizes.

    Raises:
        ValueError: the crop has another class.
    """
    if crop.class_id not in INSET_CLASSES:
        raise ValueError(f"class_id must be one of {INSET_CLASSES}. Got {crop.class_id} instead.")
    shrunk = rng.uniform(_SMALLEST, _LARGEST)
    ring = rng.uniform(_RING_FROM, _RING_TO)
    stretch = min(1.0 / rng.uniform(0.9, 1.05), 1.1)
    cx, cy, width, height = to_cxcywh(crop.box)
    rows, columns = crop.pixels.shape[:2]
    x = (np.arange(columns) + 0.5 - cx) / (width / 2)
    y = (np.arange(rows)[:, None] + 0.5 - cy) / (height / 2)
    radius = np.hypot(x, y)
    factor = _source(radius, shrunk, ring) / np.maximum(radius, 1e-6)
    # Digits may also become narrower or wider, only in the middle.
    across = np.where(radius < shrunk * _DIGITS, stretch, 1.0)
    map_x = (x * factor * across * (width / 2) + cx - 0.5).astype(np.float32)
    map_y = (y * factor * (height / 2) + cy - 0.5).astype(np.float32)
    pixels = cv2.remap(crop.pixels, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return LoadedCrop(np.asarray(pixels, dtype=np.uint8), crop.box, crop.class_id)


def inset_crops(crops: Sequence[LoadedCrop], each: int, generator: np.random.Generator) -> list[LoadedCrop]:
    """For one training, so many crops of each limit among ``crops`` with smaller digits, from random ones of them."""
    made = []
    for class_id in INSET_CLASSES:
        own = [crop for crop in crops if crop.class_id == class_id]
        made += [inset_crop(own[k], generator) for k in generator.integers(0, len(own), each)] if own else []
    return made


def _source(radius: NDArray[np.float64], shrunk: float, ring: float) -> NDArray[np.float64]:
    """The radius in the original of the pixels at a radius, both as shares of the sign's radius.

    Digits come from a larger circle, the field from the gap between digits and ring, and the ring from the ring.
    """
    place = (0.0, shrunk * _DIGITS, ring - _EDGE / 2, ring + _EDGE / 2, 1.0, 8.0)
    origin = (0.0, _DIGITS, _FIELD, _RING, 1.0, 8.0)
    return np.interp(radius, place, origin)
