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
    """``M_off``: finds signs in one picture, without state.

    ACF is the default; an ONNX network or imported boxes can replace it.
    """

    name: str

    def detect(self, picture: Picture) -> Detections:
        """Detections of one BGR picture of any size, best first, after non-maximum suppression.

        Raises:
            ValueError: the picture is not uint8 of shape (h, w, 3), or has no pixel.
        """
        ...


class PixelSource(Protocol):
    """Read access to one frame's pixels: the frame itself, or its regions in the evidence."""

    width: int
    height: int

    def crop(self, x1: int, y1: int, x2: int, y2: int) -> Picture:
        """The BGR pixels of ``[x1, x2) x [y1, y2)``; the frame's border is replicated beyond its edges."""
        ...


class TrainedPart(Protocol):
    """A component of a model folder: arrays, and the settings that inference needs."""

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
    """The result of window rescoring at one place.

    Attributes:
        box: shape (4,), on the sign's edges, with the same box inset as a detection.
        score: log-odds of being a sign, like a detection's raw score.
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
NO_CUT_EDGES: Edges = (False, False, False, False)
"""No edge of a box was cut off."""


@dataclass(frozen=True, slots=True)
class MeasurementQuality:
    """Quality of a measured box, relative to a detection that lies wholly in the picture.

    Attributes:
        centre: factor on the standard deviations of the centre, > 0.
        size: factor on the standard deviations of width and height, > 0.
        cut: edges that the picture cuts off.
    """

    centre: float = 1.0
    size: float = 1.0
    cut: Edges = NO_CUT_EDGES

    def times(self, factor: float) -> MeasurementQuality:
        """The same cut edges, with standard deviations multiplied by ``factor``."""
        return MeasurementQuality(self.centre * factor, self.size * factor, self.cut)


FULL_QUALITY = MeasurementQuality()
"""A detection that lies wholly in the picture."""


class MotionModel(Protocol):
    """A stateless filter over ``(cx, cy, w, h)`` measurements: arrays in, arrays out.

    Measurements and ``box_of`` use centre and size in px. ``dt`` is a number of nominal frame intervals (1.0 at a
    constant rate). ``shift`` is the global camera shift (dx, dy) of the picture since the last frame, in px.
    """

    name: str

    def initiate(self, measurement: FloatArray, width: int, height: int) -> MotionState:
        """The state after the first measurement of a track, in a frame of width x height px."""
        ...

    def predict(
        self, state: MotionState, dt: float, shift: tuple[float, float], focus_y: float | None = None
    ) -> MotionState:
        """Time update.

        Args:
            state: state of the last frame.
            dt: time since then, nominal frame intervals.
            shift: global camera shift since then, px.
            focus_y: row of the camera's focus of expansion, px; None: unknown. Not every model uses it.
        """
        ...

    def update(
        self, state: MotionState, measurement: FloatArray, quality: MeasurementQuality = FULL_QUALITY
    ) -> MotionState:
        """Measurement update by ``(cx, cy, w, h)``; ``quality`` scales its noise."""
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
        """Shape (n, c), rows sum to 1. A crop holds the sign's box and a border of ``margin`` around it."""
        ...

    @property
    def margin(self) -> float:
        """Border that a crop must have on each side of the box, as a share of the box's side."""
        ...
