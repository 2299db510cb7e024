"""The input of one step of the core."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tsr_engine.protocols import PixelSource
from tsr_engine.records import Detections, FloatArray

__all__ = ["FrameInput", "Revisit"]

Revisit = Callable[[FloatArray], Detections]
"""From boxes, shape (n, 4), where signs are expected to the frame's detections, these included."""


@dataclass(frozen=True, slots=True)
class FrameInput:
    """One frame as the core sees it, live or in a replay.

    Attributes:
        ordinal: the frame's 0-based position in presentation order.
        seconds: presentation time.
        detections: offline detections, best first.
        shift: global camera shift since the previous frame, px.
        pixels: the frame's pixels; everything the core looks at comes from here.
        revisit: completes the detections where the scan is spread over several frames; None: they are complete, as
            stored ones are.
    """

    ordinal: int
    seconds: float
    detections: Detections
    shift: tuple[float, float]
    pixels: PixelSource
    revisit: Revisit | None = None
