"""Checks anchors, and completes those that the picture's edge cuts off."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from tsr_engine.errors import UsageError
from tsr_engine.follow.known_shape import WindowScorer, match_known_shape
from tsr_engine.follow.records import Anchor, Pictures
from tsr_engine.follow.template import Template
from tsr_engine.geometry.boxes import MIN_SIDE, clip
from tsr_engine.records import FloatArray, Picture

_EDGE_DISTANCE_PX: Final = 1.0
"""Distance from the picture's edge, px, within which the edge cuts a box off."""
_MIN_ASPECT_RATIO: Final = 0.5
"""Least ratio of shorter to longer side of the visible part of a sign that is cut off."""
_EXTENSION_SHARE: Final = 1 / 7
"""Assumed extent beyond the picture's edge, as a share of the visible part, of a sign of unknown shape."""
_MAX_ASPECT_DIFFERENCE: Final = math.log(1.2)
"""Difference of the aspect ratio, natural logarithm, above which two anchors show different parts of the sign."""
_MIN_CONTRAST: Final = 2.0
"""Standard deviation of a box's pixels, grey levels, below which there is nothing to match."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacedAnchor:
    """An anchor that can be followed.

    Attributes:
        frame: ordinal.
        visible_box: the person's box, shape (4,), px, clipped to the picture.
        box: the whole sign's box, shape (4,), px; may reach beyond the picture.
        template: template of the sign.
        extension_error: error of the box if it reaches beyond the picture, as a share of its size; 0 for a box within.
    """

    frame: int
    visible_box: FloatArray
    box: FloatArray
    template: Template
    extension_error: float


def place_anchors(
    pictures: Pictures, anchors: Sequence[Anchor], window_scorer: WindowScorer | None
) -> list[PlacedAnchor]:
    """Check anchors and cut their templates.

    Args:
        pictures: returns frames by ordinal.
        anchors: anchors in any order.
        window_scorer: the offline detector's later stages; None: there is no detector.

    Returns:
        The anchors in the order of their frames.

    Raises:
        UsageError: there are no anchors, two have the same frame, or one cannot be followed.
    """
    if not anchors:
        raise UsageError("Following needs a box to start from. Name at least one.")
    ordered = sorted(anchors, key=lambda anchor: anchor.frame)
    for before, after in pairwise(ordered):
        if before.frame == after.frame:
            raise UsageError(f"Frame {after.frame} has two boxes. Keep the right one.")
    return [_place_anchor(pictures, anchor, window_scorer) for anchor in ordered]


def _place_anchor(pictures: Pictures, anchor: Anchor, window_scorer: WindowScorer | None) -> PlacedAnchor:
    frame = anchor.frame
    box = np.asarray(anchor.box, dtype=np.float64)
    if box.shape != (4,) or not np.isfinite(box).all():
        raise UsageError(
            f"The box of frame {frame} must be four finite numbers x1,y1,x2,y2. Got {_as_text(anchor.box)}."
        )
    if box[2] <= box[0] or box[3] <= box[1]:
        raise UsageError(f"The box of frame {frame} must have x1 < x2 and y1 < y2. Got {_as_text(box)}.")
    shown = pictures(frame) if frame >= 0 else None
    if shown is None:
        raise UsageError(f"The video has no frame {frame}. Choose a box in one of its frames.")
    height, width = shown.picture.shape[:2]
    inside = clip(box, width, height)
    if (inside[2:] <= inside[:2]).any():
        raise UsageError(
            f"The box of frame {frame} lies outside the picture of {width}x{height} px. Got {_as_text(box)}; draw it "
            "on the sign."
        )
    if (inside[2:] - inside[:2] < MIN_SIDE).any():
        raise UsageError(
            f"The box of frame {frame} is too small to be followed: expected at least {MIN_SIDE:g} px each way in "
            f"the picture. Got {_as_text(box)}; draw it where the sign is larger."
        )
    if shown.corrupt:
        raise UsageError(
            f"Frame {frame} is damaged in the file, so its pixels do not show the sign. Draw the box in another frame."
        )
    if _contrast(shown.picture, inside) < _MIN_CONTRAST:
        raise UsageError(
            f"The box of frame {frame} shows only one colour, so there is nothing to follow. Draw it where the sign is "
            "visible."
        )
    whole = _complete_box(box, shown.picture, window_scorer)
    guess = 0.0 if (whole == box).all() else _EXTENSION_SHARE / 2.0
    return PlacedAnchor(frame, inside, whole, Template.cut(shown.picture, whole, 0.0, True), guess)


def templates_of(start: PlacedAnchor, placed: Sequence[PlacedAnchor]) -> list[Template]:
    """The templates of all anchors that show the same part of the sign as ``start``."""
    return [
        other.template
        for other in placed
        if abs(_log_aspect(other.box) - _log_aspect(start.box)) <= _MAX_ASPECT_DIFFERENCE
    ]


def _log_aspect(box: FloatArray) -> float:
    return math.log((box[2] - box[0]) / (box[3] - box[1]))


def _complete_box(box: FloatArray, picture: Picture, window_scorer: WindowScorer | None) -> FloatArray:
    """The whole sign's box if the picture's edge cuts it off: square if the detector knows its shape."""
    height, width = picture.shape[:2]
    extended = extend_beyond_edge(box, width, height)
    if (extended == box).all():
        return box
    square = extend_to_square(box, width, height)
    return extended if match_known_shape(window_scorer, picture, square) is None else square


def extend_beyond_edge(box: FloatArray, width: int, height: int) -> FloatArray:
    """Extend a box beyond the picture's edges that cut it off, by a seventh of the visible part.

    People draw a sign where most of it is visible. If nothing to a quarter of the sign is hidden, the error of this
    extension is at most an eighth.

    Args:
        box: shape (4,), px.
        width: width of the picture, px.
        height: height of the picture, px.
    """
    extension = _EXTENSION_SHARE * (box[2:] - box[:2])
    low = np.where(np.abs(box[:2]) <= _EDGE_DISTANCE_PX, box[:2] - extension, box[:2])
    high = np.where(np.abs(box[2:] - [width, height]) <= _EDGE_DISTANCE_PX, box[2:] + extension, box[2:])
    return np.concatenate([low, high])


def extend_to_square(box: FloatArray, width: int, height: int) -> FloatArray:
    """Extend a box beyond the picture's edge that cuts it off, to a square.

    A box whose sides differ by more than a factor of two stays as it is. At least half of a drawn sign is visible, so
    such a box belongs to a long board.

    Args:
        box: shape (4,), px.
        width: width of the picture, px.
        height: height of the picture, px.
    """
    x1, y1, x2, y2 = (float(v) for v in box)
    width_px, height_px = x2 - x1, y2 - y1
    if min(width_px, height_px) < _MIN_ASPECT_RATIO * max(width_px, height_px):
        return np.array([x1, y1, x2, y2])
    if width_px < height_px:
        if x1 <= _EDGE_DISTANCE_PX:
            x1 = x2 - height_px
        elif x2 >= width - _EDGE_DISTANCE_PX:
            x2 = x1 + height_px
    elif y1 <= _EDGE_DISTANCE_PX:
        y1 = y2 - width_px
    elif y2 >= height - _EDGE_DISTANCE_PX:
        y2 = y1 + width_px
    return np.array([x1, y1, x2, y2])


def _contrast(picture: Picture, box: FloatArray) -> float:
    """Largest standard deviation of a channel in a box."""
    x1, y1 = np.floor(box[:2]).astype(int)
    x2, y2 = np.ceil(box[2:]).astype(int)
    return float(picture[y1:y2, x1:x2].reshape(-1, 3).std(axis=0).max())


def _as_text(box: object) -> str:
    return ",".join(f"{float(v):g}" for v in np.asarray(box, dtype=np.float64).ravel())
