"""Converts anchors as given to anchors that can be followed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from tsr_engine.errors import UsageError
from tsr_engine.follow.known_shape import Look, know
from tsr_engine.follow.records import Anchor, Pictures
from tsr_engine.follow.template import Template
from tsr_engine.geometry.boxes import LEAST_SIDE, clip
from tsr_engine.records import FloatArray, Picture

__all__ = ["Placed", "continued", "looks_from", "opened", "place"]

_TOUCHES: Final = 1.0
"""px: a box that is so near the picture's edge ends there because the picture does."""
_LEAST_SHAPE: Final = 0.5
"""Shorter side / longer side of what is seen of a sign whose edge is cut off."""
_BEYOND: Final = 1 / 7
"""Share of what is seen of a sign that is assumed beyond the picture's edge, where nothing else is known."""
_ALIKE: Final = math.log(1.2)
"""Anchors whose width / height differs by more than this, natural logarithm, show different parts of the sign."""
_FLAT: Final = 2.0
"""Grey levels: pixels whose standard deviation is below this show nothing that could be found again."""


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """An anchor that can be followed.

    Attributes:
        frame: ordinal.
        shown: the person's box, cut to the picture, shape (4,).
        box: the whole sign's box, which may reach beyond the picture.
        look: how the sign looks.
        guess: error of the box where it goes on beyond the picture, a share of its size; 0: all of the sign is seen.
    """

    frame: int
    shown: FloatArray
    box: FloatArray
    look: Template
    guess: float


def place(pictures: Pictures, anchors: Sequence[Anchor], look: Look | None) -> list[Placed]:
    """Check anchors, and take their looks.

    Args:
        pictures: gives frames by ordinal.
        anchors: as they are given.
        look: the offline detector's later stages; None: there is no detector.

    Returns:
        In the order of their frames.

    Raises:
        UsageError: there is none, or one cannot be followed.
    """
    if not anchors:
        raise UsageError("Following needs a box to start from. Name at least one.")
    ordered = sorted(anchors, key=lambda anchor: anchor.frame)
    for before, after in pairwise(ordered):
        if before.frame == after.frame:
            raise UsageError(f"Frame {after.frame} has two boxes. Keep the right one.")
    return [_placed(pictures, anchor, look) for anchor in ordered]


def _placed(pictures: Pictures, anchor: Anchor, look: Look | None) -> Placed:
    frame = anchor.frame
    box = np.asarray(anchor.box, dtype=np.float64)
    if box.shape != (4,) or not np.isfinite(box).all():
        raise UsageError(
            f"The box of frame {frame} must be four finite numbers x1,y1,x2,y2. Got {_reported(anchor.box)}."
        )
    if box[2] <= box[0] or box[3] <= box[1]:
        raise UsageError(f"The box of frame {frame} must have x1 < x2 and y1 < y2. Got {_reported(box)}.")
    shown = pictures(frame) if frame >= 0 else None
    if shown is None:
        raise UsageError(f"The video has no frame {frame}. Choose a box of one that it has.")
    height, width = shown.picture.shape[:2]
    inside = clip(box, width, height)
    if (inside[2:] <= inside[:2]).any():
        raise UsageError(
            f"The box of frame {frame} lies outside the picture of {width}x{height} px. Got {_reported(box)}; draw it "
            "on "
            "the sign."
        )
    if (inside[2:] - inside[:2] < LEAST_SIDE).any():
        raise UsageError(
            f"The box of frame {frame} is too small to be followed: expected at least {LEAST_SIDE:g} px each way in "
            f"the picture. Got {_reported(box)}; draw it where the sign is larger."
        )
    if shown.corrupt:
        raise UsageError(
            f"Frame {frame} is damaged in the file, so its pixels are not the sign's. Draw the box in another frame."
        )
    if _contrast(shown.picture, inside) < _FLAT:
        raise UsageError(
            f"The box of frame {frame} shows one colour only, so there is nothing to find again. Draw it where the "
            "sign can be seen."
        )
    whole = _whole(box, shown.picture, look)
    guess = 0.0 if (whole == box).all() else _BEYOND / 2.0
    return Placed(frame, inside, whole, Template.cut(shown.picture, whole, 0.0, True), guess)


def looks_from(start: Placed, placed: Sequence[Placed]) -> list[Template]:
    """What to look for from an anchor on: the looks of all anchors that show as much of the sign as it does."""
    return [other.look for other in placed if abs(_shape(other.box) - _shape(start.box)) <= _ALIKE]


def _shape(box: FloatArray) -> float:
    return math.log((box[2] - box[0]) / (box[3] - box[1]))


def _whole(box: FloatArray, picture: Picture, look: Look | None) -> FloatArray:
    """The whole sign's box where the picture's edge cuts it: how far it goes on is known of a sign that is known."""
    height, width = picture.shape[:2]
    beyond = continued(box, width, height)
    if (beyond == box).all():
        return box
    square = opened(box, width, height)
    return beyond if know(look, picture, square) is None else square


def continued(box: FloatArray, width: int, height: int) -> FloatArray:
    """A box that goes on a little beyond the picture's edge where it ends there.

    Signs are drawn where most of them is seen. Between nothing and a quarter that is hidden, a seventh of what is seen
    is wrong by an eighth at most.

    Args:
        box: shape (4,), px.
        width: of the picture, px.
        height: of the picture, px.
    """
    more = _BEYOND * (box[2:] - box[:2])
    low = np.where(np.abs(box[:2]) <= _TOUCHES, box[:2] - more, box[:2])
    high = np.where(np.abs(box[2:] - [width, height]) <= _TOUCHES, box[2:] + more, box[2:])
    return np.concatenate([low, high])


def opened(box: FloatArray, width: int, height: int) -> FloatArray:
    """A box that the picture's edge cuts, made as wide as it is high, or as high as it is wide.

    A box of less than half that shape is a long board's: of a sign that is drawn, at least half is seen.

    Args:
        box: shape (4,), px.
        width: of the picture, px.
        height: of the picture, px.
    """
    x1, y1, x2, y2 = (float(v) for v in box)
    across, down = x2 - x1, y2 - y1
    if min(across, down) < _LEAST_SHAPE * max(across, down):
        return np.array([x1, y1, x2, y2])
    if across < down:
        if x1 <= _TOUCHES:
            x1 = x2 - down
        elif x2 >= width - _TOUCHES:
            x2 = x1 + down
    elif y1 <= _TOUCHES:
        y1 = y2 - across
    elif y2 >= height - _TOUCHES:
        y2 = y1 + across
    return np.array([x1, y1, x2, y2])


def _contrast(picture: Picture, box: FloatArray) -> float:
    """Largest standard deviation of a channel in a box."""
    x1, y1 = np.floor(box[:2]).astype(int)
    x2, y2 = np.ceil(box[2:]).astype(int)
    return float(picture[y1:y2, x1:x2].reshape(-1, 3).std(axis=0).max())


def _reported(box: object) -> str:
    return ",".join(f"{float(v):g}" for v in np.asarray(box, dtype=np.float64).ravel())
