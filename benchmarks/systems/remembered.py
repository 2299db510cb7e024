"""Stores detections of the long experiments with these systems, so that they can continue after a stop."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.peers.cache import digest_of
from benchmarks.systems.video import Seen
from tsr_engine.records import Detections

__all__ = ["plain_detections", "plain_seen", "read_detections", "read_seen", "systems_code"]

_DETECTING: Final = (
    "colour_model", "colour_mser", "hog", "hog_blocks", "hog_cascade", "hog_scan", "hog_svm", "proposals", "video",
)  # fmt: skip
"""Modules of this folder that detections and their times depend on."""


@cache
def systems_code() -> str:
    """Digest of the source of the code that detects; part of the key of stored detections."""
    folder = Path(__file__).parent
    return digest_of(folder, [folder / f"{name}.py" for name in _DETECTING])


def plain_detections(found: Detections) -> list[object]:
    """Detections as exact JSON values."""
    return [found.boxes.tolist(), found.raw_scores.tolist(), found.prior.tolist(), found.scores.tolist()]


def read_detections(record: Sequence[object]) -> Detections:
    """The reverse of :func:`plain_detections`."""
    boxes, raw, prior, scores = (np.array(column, dtype=np.float64) for column in record)
    return Detections(boxes.reshape(-1, 4), raw, prior, scores)


def plain_seen(seen: Seen) -> list[object]:
    """A frame as exact JSON values."""
    return [seen.ordinal, seen.seconds, list(seen.size), list(seen.shift), plain_detections(seen.detections)]


def read_seen(record: list[Any]) -> Seen:  # Any: values of a JSON record
    """The reverse of :func:`plain_seen`."""
    ordinal, seconds, (width, height), (x, y), found = record
    return Seen(ordinal, seconds, (width, height), (x, y), read_detections(found))
