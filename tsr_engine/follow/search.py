"""Searches a picture for a template: by correlation over place and scale, then by alignment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tsr_engine.follow.alignment import align
from tsr_engine.follow.template import Template, View, level_below, size_of, view
from tsr_engine.geometry.boxes import to_xyxy
from tsr_engine.online.relocalisation import parabola_peak
from tsr_engine.records import FloatArray, Picture

_COARSE_SIZE_PX: Final = 16.0
"""Largest size of the box in the search by correlation, px."""
_COARSE_SIZE_WIDE_PX: Final = 11.3
"""The same for a search radius larger than the box, px."""
_SCALE_STEP: Final = 0.09
"""Largest distance of neighbouring scales of the search, natural logarithm; alignment corrects half of it."""
_ONE_SCALE_SPREAD: Final = 0.035
"""Spread of the size below which one scale suffices."""
_DISTANCE_PENALTY: Final = 0.1
"""Correlation that a place at the edge of the search area loses, compared with the middle."""
_MAX_REACH: Final = 2.0
"""Largest search distance on each side of the box, in sides of the box."""
_MAX_ENLARGEMENT: Final = 1.4
"""Largest enlargement of a template; beyond it, the comparison gains no detail."""
_MAX_ALIGNMENT_MOVE: Final = 0.4
"""Largest valid move of the alignment, as a share of the box; beyond it, it has left the correct minimum."""
_MAX_ALIGNMENT_LOG_SCALE: Final = 0.3
"""Largest valid change of size by the alignment, natural logarithm."""
_MIN_ERROR_PX: Final = 0.12
"""Least error of an alignment, px of the comparison."""
_ERROR_PER_DISSIMILARITY: Final = 0.12
"""Error of the size per unit of correlation below 1, natural logarithm."""


@dataclass(frozen=True, slots=True)
class Match:
    """The result of a search.

    Attributes:
        box: shape (4,), px.
        variance: variance of the natural logarithm of the box's size.
        similarity: largest correlation with a template, in [-1, 1].
        anchor_similarity: largest correlation with an anchor's template, in [-1, 1].
    """

    box: FloatArray
    variance: float
    similarity: float
    anchor_similarity: float


def search(
    picture: Picture, templates: Sequence[Template], box: FloatArray, stretch: float, radius: float, spread: float
) -> Match | None:
    """Search for templates around a box.

    Args:
        picture: BGR, uint8.
        templates: templates to compare, the most suitable first.
        box: expected box of the sign, shape (4,), px.
        stretch: root of width / height of the sign.
        radius: search radius around the box's centre, px.
        spread: largest difference in size, natural logarithm.

    Returns:
        The match; None if no template could be aligned.
    """
    start = _search_coarse(picture, templates[:2], box, stretch, radius, spread)
    aligned: list[tuple[float, FloatArray, float, float, bool]] = []
    size = size_of(start)
    for template in templates:
        level = min(level_below(size), level_below(template.size * _MAX_ENLARGEMENT))
        pixels, weights = template.at_level(level)
        region = view(picture, start, level, 0.35 * level + 3.0)
        middle = region.middle
        x, y, scale, similarity, _, error = align(
            region.pixels, pixels, _weights_inside(weights, region, picture), np.array([middle, middle, 1.0])
        )
        moved = np.array([x - middle, y - middle])
        if not (np.isfinite(scale) and abs(math.log(max(scale, 1e-3))) < _MAX_ALIGNMENT_LOG_SCALE):
            continue
        if np.abs(moved).max() > _MAX_ALIGNMENT_MOVE * level + 3.0:
            continue
        dissimilarity_error = _ERROR_PER_DISSIMILARITY * max(0.0, 1.0 - similarity)
        variance = template.variance + (_MIN_ERROR_PX / level) ** 2 + error**2 + dissimilarity_error**2
        centre = region.centre + moved / region.scale
        aligned.append((variance, centre, math.log(size * scale), similarity, template.anchor))
    if not aligned:
        return None
    precision = 1.0 / np.array([row[0] for row in aligned])
    centre = precision @ np.array([row[1] for row in aligned]) / precision.sum()
    fitted_size = math.exp(float(precision @ np.array([row[2] for row in aligned]) / precision.sum()))
    return Match(
        to_xyxy(np.array([*centre, fitted_size * stretch, fitted_size / stretch])),
        # The errors of templates are correlated, so several are hardly better than the best one.
        max(1.0 / precision.sum(), 0.6 * min(row[0] for row in aligned)),
        max(row[3] for row in aligned),
        max((row[3] for row in aligned if row[4]), default=0.0),
    )


def _search_coarse(
    picture: Picture, templates: Sequence[Template], box: FloatArray, stretch: float, radius: float, spread: float
) -> FloatArray:
    """The box at the best place and scale by correlation; the given box if nothing can be compared."""
    size = size_of(box)
    # A search in a large area or over many sizes uses fewer pixels.
    level = min(_COARSE_SIZE_PX if radius < size else _COARSE_SIZE_WIDE_PX, max(size, 8.0))
    reach = min(radius * level / size, _MAX_REACH * level)
    region = view(picture, box, level, reach)
    best, best_box = -2.0, box
    for template in templates:
        for scale in _scales(spread):
            pixels, weights = template.at_level(level * scale)
            h, w = weights.shape
            if max(h, w) > len(region.pixels):
                continue
            response = cv2.matchTemplate(
                region.pixels, pixels, cv2.TM_CCOEFF_NORMED, mask=np.repeat(weights[..., None], 3, axis=2)
            )
            response[~(np.abs(response) <= 1.01)] = -1.0  # areas of one colour have no correlation
            across = np.arange(response.shape[1]) + (w - 1) / 2.0 - region.middle
            down = np.arange(response.shape[0]) + (h - 1) / 2.0 - region.middle
            score = response - _DISTANCE_PENALTY * ((across / reach) ** 2 + (down / reach)[:, None] ** 2)
            i, j = np.unravel_index(int(score.argmax()), score.shape)
            if score[i, j] > best:
                best = float(score[i, j])
                x, y = across[j] + parabola_peak(score[i], int(j)), down[i] + parabola_peak(score[:, j], int(i))
                centre = region.centre + np.array([x, y]) / region.scale
                best_box = to_xyxy(np.array([*centre, size * scale * stretch, size * scale / stretch]))
    return best_box


def _scales(spread: float) -> list[float]:
    """Scales to try, evenly spaced in their logarithm."""
    steps = math.ceil(spread / _SCALE_STEP) if spread > _ONE_SCALE_SPREAD else 0
    return [math.exp(spread * i / max(steps, 1)) for i in range(-steps, steps + 1)]


def _weights_inside(weights: NDArray[np.float32], region: View, picture: Picture) -> NDArray[np.float32]:
    """Weights without the pixels that would lie beyond the picture."""
    height, width = picture.shape[:2]
    h, w = weights.shape
    x = region.centre[0] + (np.arange(w) - (w - 1) / 2.0) / region.scale
    y = region.centre[1] + (np.arange(h) - (h - 1) / 2.0) / region.scale
    inside = ((x > 1.0) & (x < width - 1.0))[None, :] & ((y > 1.0) & (y < height - 1.0))[:, None]
    return weights if inside.all() else (weights * inside).astype(np.float32)
