"""Immutable records of everything the engine knows about one frame.

Conventions of the whole engine:

* a **box** is ``(x1, y1, x2, y2)`` in 0-based pixel-edge coordinates, ``x2, y2`` exclusive, float64;
* a **picture** is BGR, uint8, shape ``(height, width, 3)``, C-contiguous, upright;
* a **frame** is named by its ordinal: the 0-based position in presentation order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Picture = NDArray[np.uint8]

Source = Literal["detected", "predicted", "relocalised"]
TrackState = Literal["tentative", "confirmed", "dead"]
Transform = Literal["learned", "unlearned"]


@dataclass(frozen=True, slots=True)
class Detections:
    """The offline detections of one frame, best first.

    Attributes:
        boxes: shape (n, 4), float64, ``x1, y1, x2, y2`` in pixels, finite.
        raw_scores: shape (n,), the detector's score before the spatial prior; NaN: an imported file has no score.
        prior: shape (n,), ``P_spatial`` at the box centre, in [0, 1] (Eq. 2).
        scores: shape (n,), the final score ``raw + (P - 1/2) * lambda`` (Eq. 2); NaN as for ``raw_scores``.

    Raises:
        ValueError: a shape does not fit, a box is not finite, or a score is infinite.
    """

    boxes: FloatArray
    raw_scores: FloatArray
    prior: FloatArray
    scores: FloatArray

    def __post_init__(self) -> None:
        n = len(self.boxes)
        if self.boxes.shape != (n, 4):
            raise ValueError(f"Detections.boxes must have shape (n, 4). Got {self.boxes.shape} instead.")
        for name in ("raw_scores", "prior", "scores"):
            if getattr(self, name).shape != (n,):
                raise ValueError(f"Detections.{name} must have shape ({n},). Got {getattr(self, name).shape} instead.")
        # One such value would spread through the track's filter into every later frame.
        finite = np.isfinite(self.boxes)
        if not finite.all():
            row = int(np.flatnonzero(~finite.all(axis=1))[0])
            raise ValueError(f"Detections.boxes must be finite. Got {self.boxes[row].tolist()} in row {row} instead.")
        for name in ("raw_scores", "prior", "scores"):
            infinite = np.isinf(getattr(self, name))
            if infinite.any():
                row = int(infinite.argmax())
                raise ValueError(
                    f"Detections.{name} must not be infinite. Got {float(getattr(self, name)[row])} in row {row}."
                )

    def __len__(self) -> int:
        return len(self.boxes)

    @classmethod
    def empty(cls) -> Detections:
        """No detections."""
        zero = np.zeros(0)
        return cls(np.zeros((0, 4)), zero, zero, zero)

    def select(self, index: Any) -> Detections:  # Any: NumPy types any() of a mask as a scalar too
        """The detections that a NumPy index or mask selects, in its order."""
        return Detections(self.boxes[index], self.raw_scores[index], self.prior[index], self.scores[index])

    def joined(self, more: Detections) -> Detections:
        """These detections, followed by those of ``more``."""
        names = ("boxes", "raw_scores", "prior", "scores")
        return Detections(*(np.concatenate([getattr(self, name), getattr(more, name)]) for name in names))


@dataclass(frozen=True, slots=True)
class Prediction:
    """A motion model's estimate of one track in one frame, before the frame's measurement.

    Attributes:
        box: shape (4,), the predicted box.
        covariance: shape (4, 4), innovation covariance of ``(cx, cy, w, h)`` in px^2.
    """

    box: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, slots=True)
class GateVerdict:
    """The gate's factors and verdict for one predicted crop (Eq. 3)."""

    symmetry_magnitude: float
    """Strength of the best mirror axis, in [0, 1]."""
    symmetry: float
    """``symm``: reciprocal of the floored magnitude, >= 1."""
    hash_distance: float
    """``p_ph``: Hamming distance of the perceptual hashes, 0..64."""
    position_distance: float
    """``p_pos``: distance of the candidate's centre from the previous result's, in ``position_unit``."""
    l_positive: float
    """The product of the three factors; lower is better."""
    confident: bool
    """``l_positive < tau``."""


@dataclass(frozen=True, slots=True)
class Relocalisation:
    """The result of the online detector's search around a prediction (Algorithm 2)."""

    search_box: FloatArray
    """Shape (4,): the smallest box around all windows that were scored."""
    box: FloatArray
    """Shape (4,): the window with the highest response."""
    decision: float
    """SVM decision value of that window."""
    probability: float
    """Logistic of the decision value, P(y = 1)."""
    runner_up_box: FloatArray
    """Shape (4,): the best window outside the neighbourhood of ``box``."""
    runner_up_decision: float
    """SVM decision value of the runner-up."""
    windows: int
    """Number of windows that were scored."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One sample that the online detector learned or unlearned."""

    transform: Transform
    label: int
    """+1 or -1."""
    origin: Literal["offline", "prediction", "result", "background"]
    frame: int
    """Frame that the sample was cut from (-1 for offline samples)."""


@dataclass(frozen=True, slots=True)
class Recognition:
    """Per-frame class probabilities and the votes fused so far (Eq. 4, 5)."""

    probabilities: NDArray[np.float32]
    """Shape (c,): P(c | x_t) of this crop, sums to 1."""
    scale: float
    """s_t: the crop's side in px."""
    weight: float
    """w_t >= 0."""
    votes: FloatArray
    """Shape (c,): sum of w_t P(c | x_t) up to this frame."""
    class_id: int
    """argmax of the votes."""
    share: float
    """The winner's votes divided by all votes, in [0, 1]."""
    runner_up: int
    """The class with the second most votes."""


@dataclass(frozen=True, slots=True)
class TrackFrame:
    """Everything known about one track in one frame."""

    track_id: int
    state: TrackState
    source: Source
    box: FloatArray
    """Shape (4,): the frame's result."""
    score: float
    """Final score of the associated detection; without one, the track's last score after decay."""
    prediction: Prediction | None
    """None in the track's first frame."""
    detection: int | None
    """Row of the associated detection in the frame's ``Detections``."""
    gate: GateVerdict | None
    relocalisation: Relocalisation | None
    samples: tuple[Sample, ...]
    recognition: Recognition | None


EventKind = Literal["born", "confirmed", "rejected", "relocalised", "missed", "died", "relabelled"]


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a track, with the values that its sentence shows."""

    kind: EventKind
    track_id: int
    text: str
    values: Mapping[str, float | int | str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Region:
    """A rectangle of the frame's pixels, stored for replay.

    ``x, y`` is the top-left pixel in the frame; the rectangle lies wholly inside the frame.
    """

    x: int
    y: int
    pixels: Picture


@dataclass(frozen=True, slots=True)
class FrameEvidence:
    """All decisions of the engine about one frame."""

    ordinal: int
    seconds: float
    width: int
    height: int
    detections: Detections
    shift: tuple[float, float]
    """Global camera shift against the previous frame, px (x, y)."""
    tracks: tuple[TrackFrame, ...]
    events: tuple[Event, ...]
    regions: tuple[Region, ...]
    timings: Mapping[str, float]
    """Stage name -> seconds of this frame."""
