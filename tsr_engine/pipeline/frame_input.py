"""The input of one step of the core."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tsr_engine.protocols import PixelSource
from tsr_engine.records import Detections, FloatArray

Revisit = Callable[[FloatArray], Detections]
"""Maps expected boxes, shape (n, 4), to the frame's detections, including those found at these boxes."""


@dataclass(frozen=True, slots=True)
class FrameInput:
    """The core's input for one frame, in a live run or a replay.

    Attributes:
        ordinal: the frame's 0-based position in presentation order.
        seconds: presentation time.
        detections: offline detections, best first.
        shift: global camera shift since the previous frame, px.
        pixels: the frame's pixels; the core reads no others.
        revisit: completes the detections if the scan is spread over several frames; None: they are complete, as in
            evidence.
    """

    ordinal: int
    seconds: float
    detections: Detections
    shift: tuple[float, float]
    pixels: PixelSource
    revisit: Revisit | None = None
