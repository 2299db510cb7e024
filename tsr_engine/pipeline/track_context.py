"""The state of one track besides its filter: hashes, online detector, votes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tsr_engine.gating.perceptual_hash import HashMemory
from tsr_engine.params import Params
from tsr_engine.protocols import CropClassifier, PixelSource, ScoredBox
from tsr_engine.recognition.fusion import Fusion
from tsr_engine.recognition.gtsrb_classes import CLASS_NAMES
from tsr_engine.records import FloatArray, Recognition, Relocalisation, Sample


class OnlineLearner(Protocol):
    """The online detector of one track (Algorithms 1 and 2)."""

    def learn(self, pixels: PixelSource, box: FloatArray, label: int, frame: int) -> tuple[Sample, ...]:
        """Learn one crop and unlearn old samples; returns the learned and unlearned samples."""
        ...

    def relocalise(self, pixels: PixelSource, box: FloatArray) -> Relocalisation | None:
        """The best window around a box (4,); None if the box cannot be searched."""
        ...


class OnlineMaker(Protocol):
    """Makes the online detector of a new track."""

    def __call__(self, pixels: PixelSource, box: FloatArray, frame: int) -> tuple[OnlineLearner, tuple[Sample, ...]]:
        """The detector of a track whose first box is ``box``, and its first samples."""
        ...


class WindowScorer(Protocol):
    """Rescores a place that the offline detector's scan has not found."""

    def __call__(self, pixels: PixelSource, box: FloatArray) -> ScoredBox | None:
        """Rescore a box (4,), px; None if it cannot be rescored."""
        ...


@dataclass(frozen=True, slots=True)
class Models:
    """The trained parts that decisions use.

    Attributes:
        classifier: class probabilities of crops.
        names: display name of each class.
        make_online: makes the online detector of a new track.
        window_scorer: rescores the windows that an online detector finds.
    """

    classifier: CropClassifier
    make_online: OnlineMaker | None = None
    window_scorer: WindowScorer | None = None
    names: tuple[str, ...] = CLASS_NAMES


@dataclass(slots=True)
class TrackContext:
    """State of one track besides its filter."""

    box: FloatArray
    """Result of the last frame, shape (4,)."""
    memory: HashMemory
    """Mean of the track's earlier crops."""
    fusion: Fusion
    online: OnlineLearner | None = None
    label: int | None = None
    """Fused class so far."""

    @classmethod
    def start(cls, params: Params, box: FloatArray, classes: int) -> TrackContext:
        """The context of a track in its first frame."""
        return cls(box, HashMemory.empty(), Fusion.start(params.fusion, classes))

    def vote(self, probabilities: FloatArray, scale: float) -> Recognition:
        """Add one frame's class probabilities (Eq. 4)."""
        self.fusion, recognition = self.fusion.update(probabilities, scale)
        return recognition
