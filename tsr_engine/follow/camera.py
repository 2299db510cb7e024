"""Estimates camera rotation between frames, and finds cuts of the film, from the whole picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from tsr_engine.records import Picture
from tsr_engine.tracking.camera_shift import CameraShift

__all__ = ["Camera", "Turn"]

_FLOW_WIDTH: Final = 240
"""Approximate width of the pictures for the optical flow, px."""
_SMALL: Final = (48, 27)
_CUT: Final = 0.3
"""Correlation of two reduced pictures below which they show two scenes."""
_BLANK: Final = 3.0
"""Standard deviation of a picture, grey levels, below which it shows no scene."""


@dataclass(frozen=True, slots=True)
class Turn:
    """Change from one frame to the next.

    Attributes:
        shift: shift of the picture by the camera's rotation, px.
        repeated: whether the picture repeats the last one.
        cut: whether the two pictures show two scenes.
    """

    shift: tuple[float, float]
    repeated: bool
    cut: bool


class Camera:
    """Compares each picture with the last one.

    Args:
        picture: the first picture, BGR, uint8.
    """

    def __init__(self, picture: Picture) -> None:
        self._flow = CameraShift(max(1, round(picture.shape[1] / _FLOW_WIDTH)))
        self._flow.step(picture)
        self._before = _small(picture)

    def step(self, picture: Picture) -> Turn:
        """Take the next picture."""
        now, before = _small(picture), self._before
        self._before = now
        shift = self._flow.step(picture)
        if self._flow.repeated:
            return Turn((0.0, 0.0), True, False)
        blank = min(float(now.std()), float(before.std())) < _BLANK
        alike = float(cv2.matchTemplate(now, before, cv2.TM_CCOEFF_NORMED)[0, 0])
        if not blank and alike < _CUT:
            return Turn((0.0, 0.0), False, True)
        return Turn(shift, False, False)


def _small(picture: Picture) -> Picture:
    # Every few pixels suffice; to read all pixels of a large picture would take most of the time here.
    step = max(1, picture.shape[1] // (4 * _SMALL[0]))
    thin = np.ascontiguousarray(picture[::step, ::step])
    grey: Picture = cv2.cvtColor(cv2.resize(thin, _SMALL, interpolation=cv2.INTER_AREA), cv2.COLOR_BGR2GRAY)
    return grey
