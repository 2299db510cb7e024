"""The offline detector, called for each frame of a video."""

from __future__ import annotations

from dataclasses import dataclass

from tsr_engine.detection.acf import AcfDetector
from tsr_engine.pipeline.frame_input import Revisit
from tsr_engine.protocols import OfflineDetector
from tsr_engine.records import Detections, Picture


@dataclass(frozen=True, slots=True)
class VideoDetector:
    """Interface between a run and its detector.

    Attributes:
        detector: any offline detector.
        single_core: whether each frame uses only one core, because several processes detect.
    """

    detector: OfflineDetector
    single_core: bool = False

    def detect(self, ordinal: int, picture: Picture) -> Detections:
        """Detections of a frame; independent of other frames, so in any order and any process."""
        detector = self.detector
        if isinstance(detector, AcfDetector):
            if detector.params.scan_turns > 1 and ordinal > 0:  # nothing was searched before frame 0: scan it whole
                return detector.detect_part(picture, ordinal)
            if self.single_core:
                return detector.detect_single_core(picture)
        return detector.detect(picture)

    def revisit(self, picture: Picture, found: Detections) -> Revisit | None:
        """A function that adds detections at the places where the core expects signs; None if they are complete."""
        detector = self.detector
        if not isinstance(detector, AcfDetector) or detector.params.scan_turns == 1:
            return None
        return lambda expected: detector.revisit(picture, found, expected)
