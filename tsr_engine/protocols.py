"""The interfaces of the engine's replaceable parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tsr_engine.json_shapes import JsonMapping
from tsr_engine.records import Detections, FloatArray, Picture


@runtime_checkable
class OfflineDetector(Protocol):
    """``M_off``: finds signs in one picture, without memory.

    ACF is the default; any other detector (an ONNX network, imported boxes) is a drop-in.
    """

    name: str

    def detect(self, picture: Picture) -> Detections:
        """Detections of one BGR picture of any size, best first, after non-maximum suppression.

        Raises:
            ValueError: not uint8 of shape (h, w, 3), or without a pixel.
        """
        ...


class PixelSource(Protocol):
    """Read access to one frame's pixels: the frame itself, or the rectangles kept in evidence."""

    width: int
    height: int

    def crop(self, x1: int, y1: int, x2: int, y2: int) -> Picture:
        """The BGR pixels of ``[x1, x2) x [y1, y2)``; beyond the frame the border is replicated."""
        ...


class TrainedPart(Protocol):
    """A trained part as it is read from a model folder: arrays, and the settings that inference needs."""

    @property
    def arrays(self) -> Mapping[str, NDArray[np.generic]]:
        """Arrays by name."""
        ...

    @property
    def params(self) -> JsonMapping:
        """JSON settings by name."""
        ...


@dataclass(frozen=True, slots=True)
class ScoredBox:
    """What window rescoring at one place saw.

    Attributes:
        box: on the sign's edges, drawn as a detection is; shape (4,).
        score: log-odds that there is a sign, as a detection's raw score.
    """

    box: FloatArray
    score: float


@dataclass(frozen=True, slots=True)
class MotionState:
    """A track's motion state: mean and covariance in the motion model's own coordinates."""

    mean: FloatArray
    covariance: FloatArray


Edges = tuple[bool, bool, bool, bool]
"""Left, top, right, bottom."""
WHOLE: Edges = (False, False, False, False)
"""No edge of a box was cut off."""


@dataclass(frozen=True, slots=True)
class MeasurementQuality:
    """How well a box was measured, beside a detection that lies wholly in the picture.

    Attributes:
        centre: factor on the standard deviations of a detection's centre, > 0.
        size: factor on those of its width and height, > 0.
        cut: edges that were not seen.
    """

    centre: float = 1.0
    size: float = 1.0
    cut: Edges = WHOLE

    def times(self, factor: float) -> MeasurementQuality:
        """The same edges, with ``factor`` times the standard deviations."""
        return MeasurementQuality(self.centre * factor, self.size * factor, self.cut)


FULL_QUALITY = MeasurementQuality()
"""A detection that lies wholly in the picture."""


class MotionModel(Protocol):
    """A stateless filter over ``(cx, cy, w, h)`` measurements: arrays in, arrays out.

    Measurements and ``box_of`` use centre and size in px; ``dt`` counts nominal frame intervals (1.0 at
    constant rate); ``shift`` is the global camera shift (dx, dy) of the picture since the last frame, in px.
    """

    name: str

    def initiate(self, measurement: FloatArray, width: int, height: int) -> MotionState:
        """The state of a track born from one measurement in a frame of width x height px."""
        ...

    def predict(
        self, state: MotionState, dt: float, shift: tuple[float, float], focus_y: float | None = None
    ) -> MotionState:
        """Time update; ``focus_y``: height of the camera's focus of expansion if known, px, for a model with one."""
        ...

    def update(
        self, state: MotionState, measurement: FloatArray, quality: MeasurementQuality = FULL_QUALITY
    ) -> MotionState:
        """Measurement update by a box that was seen as ``quality`` says."""
        ...

    def box_of(self, state: MotionState) -> FloatArray:
        """``(cx, cy, w, h)`` of a state, shape (4,)."""
        ...

    def innovation(self, state: MotionState) -> FloatArray:
        """Innovation covariance of ``(cx, cy, w, h)``, shape (4, 4)."""
        ...


class CropClassifier(Protocol):
    """Class probabilities of sign crops."""

    def probabilities(self, crops: list[Picture]) -> NDArray[np.float32]:
        """Shape (n, c), rows sum to 1. Each crop is the sign's box plus the border that ``margin`` names."""
        ...

    @property
    def margin(self) -> float:
        """Border on each side of the box that a crop must carry, as a share of the box's side."""
        ...
