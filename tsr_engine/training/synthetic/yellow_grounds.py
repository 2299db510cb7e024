"""Paints sign grounds yellow or orange in place of white, as in Finland, Poland, Sweden and at road works.

The Vienna Convention (1968, annex 1, C and A) leaves the choice to each country; GTSDB and GTSRB have only white.
Ring, symbol and surroundings stay unchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.records import FloatArray, Picture
from tsr_engine.training.synthetic.drawn_signs import EMPTY

__all__ = ["GROUNDED", "sometimes_yellow", "yellow_ground"]

Inside = Callable[[FloatArray, FloatArray], NDArray[np.bool_]]

MIN_GROUND_PX: Final = 6
"""Smallest ground that is painted, px."""
EMPTY_RING_FACTOR: Final = 3
"""Factor for empty rings, which are mostly ground and rare: signs with a symbol hardly show a yellow ring."""
MIN_CONTRAST: Final = 20.0
"""Least difference of grey levels between ground and paint; with less, the ground is unchanged."""


def _disc(x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
    return np.asarray(x * x + y * y < 0.82**2)


def _triangle(x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
    return np.asarray((y < 0.78) & (2 * np.abs(x) - y < 0.62))


def _inverted(x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
    return _triangle(x, -y)


_INSIDE: Final[Mapping[str, Inside]] = {"circle": _disc, "triangle": _triangle, "inverted triangle": _inverted}
"""Shape -> test whether points lie within a sign's outer rim, in coordinates from -1 to 1 across its box."""
GROUNDED: Final = {
    label.id: label.shape for label in shipped_set(DEFAULT) if label.shape in _INSIDE and label.category != "mandatory"
}
"""GTSRB class -> shape, for classes with a ground."""


def sometimes_yellow(
    picture: Picture, box: FloatArray, class_id: int, share: float, rng: np.random.Generator
) -> Picture:
    """Return the picture, in a share of the calls with a yellow ground on its sign.

    Args:
        picture: BGR, uint8.
        box: the sign, shape (4,).
        class_id: class of the sign; below 0: there is none.
        share: probability in [0, 1 / ``EMPTY_RING_FACTOR``], ``EMPTY_RING_FACTOR`` times that for an empty ring; 0
            draws no random number.
        rng: source of the choice and the paint.
    """
    if not share or class_id not in GROUNDED or rng.random() >= share * (EMPTY_RING_FACTOR if class_id == EMPTY else 1):
        return picture
    return yellow_ground(picture, box, class_id, rng)


def yellow_ground(picture: Picture, box: FloatArray, class_id: int, rng: np.random.Generator) -> Picture:
    """Give a sign in a BGR picture a yellow or orange ground.

    Blue and green separate white from red and black. A pixel loses them in proportion to its whiteness, so edges
    stay soft.

    Args:
        picture: uint8.
        box: the sign, shape (4,).
        class_id: class of the sign; classes outside ``GROUNDED`` have no ground and stay unchanged.
        rng: source of the paint.

    Returns:
        A copy, or the picture itself if there is no ground.
    """
    if class_id not in GROUNDED:
        return picture
    left, top = np.maximum(0, np.floor(box[:2])).astype(int).tolist()
    right, bottom = np.ceil(box[2:]).astype(int).tolist()
    part = picture[top:bottom, left:right].astype(np.float32)
    across, down = np.arange(part.shape[1]) + 0.5, np.arange(part.shape[0]) + 0.5
    x = (2 * (across + left) - box[0] - box[2]) / (box[2] - box[0])
    y = (2 * (down + top) - box[1] - box[3]) / (box[3] - box[1])
    inside = _INSIDE[GROUNDED[class_id]](x[None], y[:, None])
    if inside.sum() < MIN_GROUND_PX:
        return picture
    lightness = part[..., :2].min(axis=2)
    paint, ground = np.percentile(lightness[inside], (5, 85))
    if ground - paint < MIN_CONTRAST:
        return picture
    white = np.clip((lightness - paint) / (ground - paint), 0, 1) * inside
    strength = rng.uniform(0.6, 1.0)
    lost = strength * np.array([rng.uniform(0.6, 1.0), rng.uniform(0.05, 0.4), rng.uniform(-0.05, 0.05)])
    painted = picture.copy()
    painted[top:bottom, left:right] = np.clip(part * (1 - white[..., None] * lost), 0, 255).astype(np.uint8)
    return painted
