"""Stores detections of the long experiments with these systems, so that they can continue after a stop."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.cache import digest_of
from benchmarks.videos.stored_detections import DetectedFrame
from tsr_engine.records import Detections

_DETECTING: Final = (
    "colour_model", "colour_mser", "hog", "hog_blocks", "hog_cascade", "hog_scan", "hog_svm", "proposals",
    "video_detections",
)  # fmt: skip
"""Modules of this folder that detections and their times depend on."""


@cache
def systems_code() -> str:
    """Digest of the source of the code that detects; part of the key of stored detections."""
    folder = Path(__file__).parent
    return digest_of(folder, [folder / f"{name}.py" for name in _DETECTING])


def detections_to_record(found: Detections) -> list[object]:
    """Detections as exact JSON values."""
    return [found.boxes.tolist(), found.raw_scores.tolist(), found.prior.tolist(), found.scores.tolist()]


def detections_from_record(record: Sequence[object]) -> Detections:
    """The reverse of :func:`detections_to_record`."""
    boxes, raw, prior, scores = (np.array(column, dtype=np.float64) for column in record)
    return Detections(boxes.reshape(-1, 4), raw, prior, scores)


def frame_to_record(seen: DetectedFrame) -> list[object]:
    """A frame as exact JSON values."""
    return [seen.ordinal, seen.seconds, list(seen.shift), detections_to_record(seen.detections)]


def frame_from_record(record: list[Any]) -> DetectedFrame:  # Any: values of a JSON record
    """The reverse of :func:`frame_to_record`."""
    ordinal, seconds, (x, y), found = record
    return DetectedFrame(ordinal, seconds, detections_from_record(found), (x, y))
