"""The input of one step of the core."""

from __future__ import annotations

from dataclasses import dataclass

from tsr_engine.protocols import PixelSource
from tsr_engine.records import Detections

__all__ = ["FrameInput"]


@dataclass(frozen=True, slots=True)
class FrameInput:
    """One frame as the core sees it, live or in a replay.

    Attributes:
        ordinal: the frame's 0-based position in presentation order.
        seconds: presentation time.
        detections: offline detections, best first.
        shift: global camera shift since the previous frame, px.
        pixels: the frame's pixels; everything the core looks at comes from here.
    """

    ordinal: int
    seconds: float
    detections: Detections
    shift: tuple[float, float]
    pixels: PixelSource
