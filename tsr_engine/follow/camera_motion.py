"""Estimates camera rotation between frames, and finds cuts of the film, from the whole picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from tsr_engine.records import Picture
from tsr_engine.tracking.camera_shift import CameraShift

_FLOW_WIDTH: Final = 240
"""Approximate width of the pictures for the optical flow, px."""
_REDUCED_SIZE: Final = (48, 27)
_MIN_SCENE_CORRELATION: Final = 0.3
"""Correlation of two reduced pictures below which they show two scenes."""
_MIN_SCENE_CONTRAST: Final = 3.0
"""Standard deviation of a picture, grey levels, below which it shows no scene."""


@dataclass(frozen=True, slots=True)
class CameraMotion:
    """Change from one frame to the next.

    Attributes:
        shift: shift of the picture by the camera's rotation, px.
        repeated: whether the picture repeats the last one.
        cut: whether the two pictures show two scenes.
    """

    shift: tuple[float, float]
    repeated: bool
    cut: bool


class CameraMotionEstimator:
    """Compares each picture with the last one.

    Args:
        picture: the first picture, BGR, uint8.
    """

    def __init__(self, picture: Picture) -> None:
        self._flow = CameraShift(max(1, round(picture.shape[1] / _FLOW_WIDTH)))
        self._flow.step(picture)
        self._previous = _reduced_grey(picture)

    def step(self, picture: Picture) -> CameraMotion:
        """Take the next picture."""
        current, previous = _reduced_grey(picture), self._previous
        self._previous = current
        shift = self._flow.step(picture)
        if self._flow.repeated:
            return CameraMotion((0.0, 0.0), True, False)
        is_blank = min(float(current.std()), float(previous.std())) < _MIN_SCENE_CONTRAST
        correlation = float(cv2.matchTemplate(current, previous, cv2.TM_CCOEFF_NORMED)[0, 0])
        if not is_blank and correlation < _MIN_SCENE_CORRELATION:
            return CameraMotion((0.0, 0.0), False, True)
        return CameraMotion(shift, False, False)


def _reduced_grey(picture: Picture) -> Picture:
    # Every few pixels suffice; to read all pixels of a large picture would take most of the time here.
    step = max(1, picture.shape[1] // (4 * _REDUCED_SIZE[0]))
    sampled = np.ascontiguousarray(picture[::step, ::step])
    grey: Picture = cv2.cvtColor(cv2.resize(sampled, _REDUCED_SIZE, interpolation=cv2.INTER_AREA), cv2.COLOR_BGR2GRAY)
    return grey
