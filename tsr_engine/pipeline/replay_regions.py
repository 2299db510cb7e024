"""Chooses the pixels of a frame that evidence stores for replays with other parameters."""

from __future__ import annotations

import numpy as np

from tsr_engine.evidence.regions import FramePixels
from tsr_engine.geometry.boxes import area, clip, expand
from tsr_engine.online.online_detector import is_describable
from tsr_engine.online.relocalisation import search_extent
from tsr_engine.params import Params
from tsr_engine.records import FloatArray, FrameEvidence, Region


def replay_regions(frame: FrameEvidence, pixels: FramePixels, params: Params) -> tuple[Region, ...]:
    """The pixels that the step has read, and those that a replay may need.

    A replay with a search radius up to ``keep_radius`` searches around every prediction. A replay with other thresholds
    may start a track at any detection.
    """
    pipeline = params.pipeline
    online = params.online.model_copy(update={"search_radius": max(pipeline.keep_radius, params.online.search_radius)})
    for track in frame.tracks:
        if track.prediction is not None and is_describable(track.prediction.box):
            _read_box(pixels, np.array(search_extent(track.prediction.box, online), dtype=np.float64))
        _read_box(pixels, expand(track.box, pipeline.keep_context))
    for box in frame.detections.boxes:
        _read_box(pixels, expand(box, pipeline.keep_context))
    return pixels.regions()


def _read_box(pixels: FramePixels, box: FloatArray) -> None:
    """Read the part of a box that lies in the frame, so that it is kept."""
    if not np.isfinite(box).all():
        return
    inside = clip(box, pixels.width, pixels.height)
    if float(area(inside)) > 0:
        x1, y1, x2, y2 = int(np.floor(inside[0])), int(np.floor(inside[1])), *map(int, np.ceil(inside[2:]))
        pixels.crop(x1, y1, x2, y2)
