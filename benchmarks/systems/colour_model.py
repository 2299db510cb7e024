"""The colour probability model of Yang et al. 2016, [20] of the paper: the probability of a sign's colour by pixel.

Pixels are converted to the normalised Ohta plane, which cancels brightness: ``(R - B) / (R + G + B)`` and
``(2 G - R - B) / (R + G + B)``. Each sign colour is a Gaussian in it, the background a histogram of road scenes. Bayes'
rule gives a probability; a table over 32 levels of blue, green and red reduces it to one look-up per pixel.

[20] fits its Gaussians to pixels that were picked by hand. Here they come from annotated boxes alone. A box of a
red-rimmed sign holds red and other pixels. Expectation maximisation separates them, given the colours of the rest of
the scenes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.io.gtsdb import Scene
from tsr_engine.io.pictures import read_picture
from tsr_engine.records import FloatArray, Picture

COLOURS: Final[dict[str, frozenset[int]]] = {
    "red": frozenset((*range(6), *range(7, 12), *range(13, 32))),
    "blue": frozenset(range(33, 41)),
    "yellow": frozenset((12,)),
}
"""Classes whose signs have the colour; the ends of limits (6, 32, 41, 42) have none."""
LEVELS: Final = 32
"""Steps of blue, green and red in the table."""
_DARK: Final = 30.0
"""Added to R + G + B, since the hue of nearly black pixels is noise."""
_STEP: Final = 0.03
"""Size of one step of the table in the Ohta plane: the least width of a colour."""
_PIXELS_OF_SIGN: Final = 150
"""Number of pixels drawn from every sign."""
_ROUNDS: Final = 40
"""Rounds of expectation maximisation."""
_SPAN: Final = 1.2
_CELLS: Final = 96
"""Number of cells per axis of the background's histogram, which covers +-_SPAN."""


@dataclass(frozen=True, slots=True)
class ColourModel:
    """Probability of every colour for every quantised pixel.

    Attributes:
        table: shape (colours, LEVELS ** 3), uint8: 255 P(colour | pixel), index ``(b * LEVELS + g) * LEVELS + r``.
        means: shape (colours, 2), of the Gaussians in the Ohta plane.
        covariances: shape (colours, 2, 2).
    """

    table: NDArray[np.uint8]
    means: FloatArray
    covariances: FloatArray

    def maps(self, picture: Picture) -> NDArray[np.uint8]:
        """Probability maps (colours, h, w), uint8, of a BGR picture."""
        b, g, r = (channel.astype(np.uint16) >> 3 for channel in cv2.split(picture))
        index = (b << 10) | (g << 5) | r
        return np.stack([row[index] for row in self.table])


def ohta(pixels: NDArray[np.uint8]) -> FloatArray:
    """The two normalised Ohta coordinates of BGR pixels, shape (..., 3) to (..., 2)."""
    b, g, r = np.moveaxis(pixels.astype(np.float64), -1, 0)
    total = b + g + r + _DARK
    return np.stack([(r - b) / total, (2 * g - r - b) / total], axis=-1)


def fit_colours(scenes: Sequence[Scene], rng: np.random.Generator) -> ColourModel:
    """Learn the model from annotated scenes.

    Args:
        scenes: training scenes.
        rng: random generator; draws the pixels.

    Raises:
        ValueError: the scenes hold no sign of a colour.
    """
    samples: dict[str, list[FloatArray]] = {name: [] for name in COLOURS}
    background = []
    for scene in scenes:
        if not len(scene.boxes):
            continue
        picture = read_picture(scene.path)
        y, x = (rng.integers(0, side, 3000) for side in picture.shape[:2])
        background.append(ohta(picture[y, x]))
        for box, class_id in zip(scene.boxes, scene.class_ids.tolist(), strict=True):
            name = next((n for n, classes in COLOURS.items() if class_id in classes), None)
            if name is None:
                continue
            share = rng.uniform(0.08, 0.92, (_PIXELS_OF_SIGN, 2))
            places = (box[:2] + share * (box[2:] - box[:2])).astype(int)
            x, y = np.clip(places, 0, (picture.shape[1] - 1, picture.shape[0] - 1)).T
            samples[name].append(ohta(picture[y, x]))
    missing = [name for name, found in samples.items() if not found]
    if missing:
        raise ValueError(f"The colour model needs signs of every colour. Got none of {', '.join(missing)}.")
    rest = _histogram(np.concatenate(background))
    fitted = [_separate(np.concatenate(found), rest) for found in samples.values()]
    means, covariances = np.stack([m for m, _ in fitted]), np.stack([c for _, c in fitted])
    middle = (np.arange(LEVELS) * 8 + 4).astype(np.uint8)
    points = ohta(np.stack(np.meshgrid(middle, middle, middle, indexing="ij"), axis=-1).reshape(-1, 3))
    likely = np.stack([_gaussian(points, m, c) for m, c in fitted])
    posterior = likely / (likely.sum(axis=0) + _look_up(rest, points))
    return ColourModel(np.round(255 * posterior).astype(np.uint8), means, covariances)


def _histogram(points: FloatArray) -> FloatArray:
    """Smoothed density over the Ohta plane, (_CELLS, _CELLS)."""
    edges = np.linspace(-_SPAN, _SPAN, _CELLS + 1)
    counts, _, _ = np.histogram2d(points[:, 0], points[:, 1], bins=(edges, edges))
    smooth = cv2.GaussianBlur(counts + 1e-3, (0, 0), 1.0)
    return np.asarray(smooth / smooth.sum() * (_CELLS / (2 * _SPAN)) ** 2)


def _look_up(density: FloatArray, points: FloatArray) -> FloatArray:
    cells = np.clip(((points + _SPAN) * _CELLS / (2 * _SPAN)).astype(int), 0, _CELLS - 1)
    return np.asarray(density[cells[:, 0], cells[:, 1]])


def _gaussian(points: FloatArray, mean: FloatArray, covariance: FloatArray) -> FloatArray:
    away = points - mean
    square = np.einsum("ni,ij,nj->n", away, np.linalg.inv(covariance), away)
    return np.asarray(np.exp(-0.5 * square) / (2 * np.pi * np.sqrt(np.linalg.det(covariance))))


def _separate(points: FloatArray, rest: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance of the sign's colour in boxes that also hold background pixels."""
    other = _look_up(rest, points)
    # The sign's colour is where the density in the boxes exceeds that of the rest by the largest factor.
    ratio = _look_up(_histogram(points), points) / (other + 1e-6)
    mine = (ratio >= np.quantile(ratio, 0.7)).astype(float)
    mean, covariance = np.zeros(2), np.eye(2)
    for _ in range(_ROUNDS):
        share = mine.mean()
        mean = mine @ points / mine.sum()
        away = points - mean
        covariance = (mine[:, None] * away).T @ away / mine.sum() + _STEP**2 * np.eye(2)
        likely = share * _gaussian(points, mean, covariance)
        mine = likely / (likely + (1 - share) * other + 1e-12)
    return mean, covariance
