"""The state of one track besides its filter: hashes, online detector, votes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tsr_engine.gating.perceptual_hash import HashMemory
from tsr_engine.params import Params
from tsr_engine.protocols import CropClassifier, PixelSource, ScoredBox
from tsr_engine.recognition.catalogue import CLASS_NAMES
from tsr_engine.recognition.fusion import Fusion
from tsr_engine.records import FloatArray, Recognition, Relocalisation, Sample

__all__ = ["Models", "OnlineLearner", "OnlineMaker", "TrackContext", "WindowScorer"]


class OnlineLearner(Protocol):
    """The online detector of one track (Algorithms 1 and 2)."""

    def learn(self, pixels: PixelSource, box: FloatArray, label: int, frame: int) -> tuple[Sample, ...]:
        """Learn one crop, unlearn what is too old, and say what was done."""
        ...

    def relocalise(self, pixels: PixelSource, box: FloatArray, frame: int) -> Relocalisation | None:
        """The best window around a box; None where nothing can be searched."""
        ...


class OnlineMaker(Protocol):
    """Makes the online detector of a new track."""

    def __call__(self, pixels: PixelSource, box: FloatArray, frame: int) -> tuple[OnlineLearner, tuple[Sample, ...]]:
        """The detector and the samples that it starts from, given the box of the track's first frame."""
        ...


class WindowScorer(Protocol):
    """Rescores a place that the offline detector's scan has not found."""

    def __call__(self, pixels: PixelSource, box: FloatArray) -> ScoredBox | None:
        """What is seen at a box, shape (4,); None where nothing can be reported."""
        ...


@dataclass(frozen=True, slots=True)
class Models:
    """The trained parts that decisions use.

    Attributes:
        classifier: class probabilities of crops.
        names: what people read for each of its classes.
        make_online: makes the online detector of a new track.
        look: window rescoring at the windows that it finds.
    """

    classifier: CropClassifier
    make_online: OnlineMaker | None = None
    look: WindowScorer | None = None
    names: tuple[str, ...] = CLASS_NAMES


@dataclass(slots=True)
class TrackContext:
    """State of one track besides its filter."""

    box: FloatArray
    """Result of the last frame, shape (4,)."""
    memory: HashMemory
    """The looks of its earlier crops."""
    fusion: Fusion
    online: OnlineLearner | None = None
    label: int | None = None
    """Fused class so far."""

    @classmethod
    def start(cls, params: Params, box: FloatArray, classes: int) -> TrackContext:
        """The memory of a track in its first frame."""
        return cls(box, HashMemory.empty(), Fusion.start(params.fusion, classes))

    def vote(self, probabilities: FloatArray, scale: float) -> Recognition:
        """Add one frame's class probabilities (Eq. 4)."""
        self.fusion, recognition = self.fusion.update(probabilities, scale)
        return recognition
