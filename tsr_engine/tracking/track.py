"""One track: its filter state, the evidence for it, and its life cycle."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from tsr_engine.params.tracking import TrackingParams
from tsr_engine.protocols import MotionState
from tsr_engine.records import FloatArray, Prediction, Source, TrackState


@dataclass(slots=True)
class Track:
    """A sign candidate that is followed from frame to frame.

    A track is ``tentative`` until the last ``confirm_window`` frames hold ``confirm_hits`` detections of at least
    ``birth_score`` (or ``sure_hits`` of ``sure_score``), then ``confirmed`` until it dies. All counts are in frames.
    """

    track_id: int
    motion: MotionState
    box: FloatArray
    """The result of the current frame, shape (4,)."""
    score: float
    born: int
    """Ordinal of the first frame."""
    state: TrackState = "tentative"
    source: Source = "detected"
    prediction: Prediction | None = None
    detection: int | None = None
    """Row of this frame's associated detection."""
    age: int = 0
    """Frames since the first frame."""
    missed: int = 0
    """Frames since the last detection or confident relocalisation."""
    undetected: int = 0
    """Frames since the last detection."""
    hits: int = 0
    """Detections of at least ``birth_score``, over its whole life."""
    recent: deque[tuple[int, float]] = field(default_factory=deque)
    """(age, score) of the detections that count for confirmation."""
    measured: bool = False
    """Whether this frame has a measurement."""

    def begin_frame(self, prediction: Prediction, motion: MotionState) -> None:
        """Takes the time update; the prediction is the frame's result unless a measurement corrects it."""
        self.age += 1
        self.missed += 1
        self.undetected += 1
        self.motion = motion
        self.prediction = prediction
        self.box = prediction.box
        self.source = "predicted"
        self.detection = None
        self.measured = False

    def detected(self, row: int, score: float, params: TrackingParams) -> None:
        """Counts an associated detection."""
        self.detection = row
        self.score = score
        self.missed = 0
        self.undetected = 0
        if score >= params.birth_score:
            self.hits += 1
            self.recent.append((self.age, score))

    def may_confirm(self, params: TrackingParams) -> bool:
        """Whether the detections of the last ``confirm_window`` frames suffice."""
        while self.recent and self.recent[0][0] <= self.age - params.confirm_window:
            self.recent.popleft()
        hits = len(self.recent)
        mean = sum(score for _, score in self.recent) / max(hits, 1)
        if params.sure_score is not None and hits >= params.sure_hits and mean >= params.sure_score:
            return True
        return hits >= params.confirm_hits and mean >= params.confirm_score

    def missed_limit(self, params: TrackingParams) -> int:
        """Frames without a detection or confident relocalisation that this track survives.

        A tentative track survives as many as still allow its confirmation by ``confirm_hits`` within the window.
        """
        if self.state == "confirmed":
            return params.max_coast
        return min(params.max_coast, max(params.confirm_window - params.confirm_hits, 0))

    def undetected_limit(self, params: TrackingParams) -> int:
        """Frames without a detection that this track survives, even if it is relocalised.

        What the few detections of a tentative track show may be no sign, so its relocalisations prolong its life less.
        """
        return params.max_undetected if self.state == "confirmed" else min(params.max_coast, params.max_undetected)
