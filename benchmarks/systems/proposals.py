"""Proposals of signs: maximally stable regions of the colour maps, as in [20] of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.systems.colour_model import ColourModel
from tsr_engine.params.detector import DetectorParams
from tsr_engine.records import FloatArray, Picture

_STEP: Final = 0.07
_SMOOTH: Final = 0.8
"""Standard deviation, px, of the blur that removes the noise of dark places from the colour maps."""


@dataclass(frozen=True, slots=True)
class ProposalPlan:
    """Settings of the search, chosen on the calibration scenes.

    Attributes:
        delta: number of grey levels over which a region must be stable.
        max_variation: largest relative change of its area over them.
        min_diversity: least relative difference between nested regions; OpenCV's default 0.2 loses every second sign.
        grey: whether to search the grey picture as well, for signs without colour.
        thickest: largest ratio of longer to shorter side.
        widest: largest width of a sign, px.
    """

    delta: int = 4
    max_variation: float = 1.0
    min_diversity: float = 0.02
    grey: bool = True
    thickest: float = 1.5
    widest: float = 200.0


@dataclass(frozen=True, slots=True)
class Proposals:
    """Candidate boxes of one picture, and the maps that they come from.

    Attributes:
        boxes: shape (n, 4).
        maps: shape (colours, h, w), uint8.
    """

    boxes: FloatArray
    maps: NDArray[np.uint8]


def propose(picture: Picture, colours: ColourModel, plan: ProposalPlan, params: DetectorParams) -> Proposals:
    """Boxes around stable regions.

    Args:
        picture: BGR.
        colours: see :class:`ColourModel`.
        plan: see :class:`ProposalPlan`.
        params: only ``min_width`` and the band of rows of far signs are used.
    """
    height = picture.shape[0]
    maps = colours.maps(picture)
    planes = [np.asarray(cv2.GaussianBlur(plane, (0, 0), _SMOOTH), np.uint8) for plane in maps]
    if plan.grey:
        planes.append(np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8))
    least, most = 0.85 * params.min_width, plan.widest
    regions = cv2.MSER_create(  # type: ignore[attr-defined]
        delta=plan.delta,
        min_area=int(0.1 * least**2),
        max_area=int(most**2),
        max_variation=plan.max_variation,
        min_diversity=plan.min_diversity,
    )
    found = [np.zeros((0, 4))]
    for plane in planes:
        _, boxes = regions.detectRegions(plane)
        if len(boxes):
            rows = np.asarray(boxes, np.float64)
            found.append(np.concatenate([rows[:, :2], rows[:, :2] + rows[:, 2:]], axis=1))
    boxes = np.concatenate(found)
    w, h = boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1]
    long, short = np.maximum(w, h), np.minimum(w, h)
    middle = (boxes[:, 1] + boxes[:, 3]) / 2
    far = w < params.far_share * height
    level = ~far | ((middle >= params.far_top * height) & (middle <= params.far_bottom * height))
    sane = (short >= least) & (long <= most) & (long <= plan.thickest * short) & level
    return Proposals(_distinct(boxes[sane]), maps)


def _distinct(boxes: FloatArray) -> FloatArray:
    """One box of each group with equal place, width and height, up to about ``_STEP`` of the size."""
    if not len(boxes):
        return boxes
    size = np.log(boxes[:, 2:] - boxes[:, :2]) / _STEP
    side = np.exp(np.round(size.mean(axis=1)) * _STEP)
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2 / (_STEP * side[:, None])
    _, first = np.unique(np.round(np.concatenate([middle, size], axis=1)), axis=0, return_index=True)
    return boxes[np.sort(first)]
