"""Signs to follow: the frames in which they are visible, where they are drawn, and signs that vanish."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tsr_engine.follow import MIN_WIDTH_PX
from tsr_engine.geometry.boxes import clip
from tsr_engine.io.video import open_video
from tsr_engine.records import FloatArray, Picture
from tsr_engine.track_table import TrackTable

POSITIONS = {"first third": 1 / 6, "middle": 1 / 2, "last third": 5 / 6}
"""Frames in which a sign is drawn, as shares of its visible life."""
_VISIBLE = 0.5
"""Least visible share of a sign in a frame of its life."""
_CLEAR = 0.75
"""Least visible share of a sign in a frame in which it is drawn."""
_MIN_FRAMES = 6
"""Least number of frames of a life."""
_MIN_LARGEST_WIDTH_PX = 16.0
"""Least largest width of a sign, px; narrower signs cannot be recognised, and nobody draws them."""


@dataclass(frozen=True, slots=True)
class Sign:
    """One sign of a video.

    Attributes:
        sign: id of the sign in the ground truth.
        life: frame -> box, shape (4,), for frames with half of the sign visible and a box of at least 10 px width.
        rows: frame -> box, for all annotated frames.
        clear: frames of the life in which the sign can be drawn.
    """

    sign: int
    life: Mapping[int, FloatArray]
    rows: Mapping[int, FloatArray]
    clear: Sequence[int]

    def anchor(self, position: str) -> int:
        """The frame in which to draw the sign: the clear frame nearest to the position."""
        frames = sorted(self.life)
        wanted = frames[round(POSITIONS[position] * (len(frames) - 1))]
        return min(self.clear, key=lambda frame: (abs(frame - wanted), frame))


def decode(path: Path) -> list[Picture]:
    """All pictures of a video."""
    with open_video(path) as video:
        return [frame.picture for frame in video.frames()]


def signs_of(truth: TrackTable, width: int, height: int) -> list[Sign]:
    """The signs of a video that are visible for six frames and reach 16 px width, including ignored ones.

    Args:
        truth: annotated boxes.
        width: width of the pictures, px; boxes are clipped to them.
        height: height of the pictures, px.

    Returns:
        The signs, the widest first.
    """
    found = []
    for sign in np.unique(truth.track).tolist():
        place = np.flatnonzero(truth.track == sign)
        boxes = clip(truth.boxes[place], width, height)
        rows = {int(k): box for k, box in zip(truth.frame[place], boxes, strict=True)}
        seen = {int(k): float(v) for k, v in zip(truth.frame[place], truth.visibility[place], strict=True)}
        life = {k: b for k, b in sorted(rows.items()) if seen[k] >= _VISIBLE and b[2] - b[0] >= MIN_WIDTH_PX}
        clear = [k for k in life if seen[k] >= _CLEAR]
        widest = max((b[2] - b[0] for b in life.values()), default=0.0)
        if len(life) >= _MIN_FRAMES and widest >= _MIN_LARGEST_WIDTH_PX and clear:
            found.append(Sign(int(sign), life, rows, clear))
    return sorted(found, key=lambda sign: -max(b[2] - b[0] for b in sign.life.values()))


def paint_over(pictures: Sequence[Picture], sign: Sign, share: float = 0.6) -> tuple[list[Picture], Sign]:
    """Make a sign vanish: from some frame of its life on, its surroundings are painted over it.

    Args:
        pictures: pictures of the whole video.
        sign: the sign.
        share: share of its life before it vanishes.
    """
    frames = sorted(sign.life)
    last = frames[int(share * (len(frames) - 1))]
    out = list(pictures)
    for k in (k for k in sign.rows if k > last):
        picture = pictures[k].copy()
        height, width = picture.shape[:2]
        x1, y1, x2, y2 = sign.rows[k]
        rim = 0.3 * max(x2 - x1, y2 - y1) + 2.0
        left, top = int(max(0, x1 - rim)), int(max(0, y1 - rim))
        right, bottom = int(min(width, x2 + rim)), int(min(height, y2 + rim))
        wide = right - left
        source = left - wide - 4 if left - wide - 4 >= 0 else min(right + 4, width - wide)
        picture[top:bottom, left:right] = pictures[k][top:bottom, source : source + wide]
        out[k] = picture
    kept = {k: b for k, b in sign.rows.items() if k <= last}
    life = {k: b for k, b in sign.life.items() if k <= last}
    return out, replace(sign, life=life, rows=kept, clear=[k for k in sign.clear if k <= last])
