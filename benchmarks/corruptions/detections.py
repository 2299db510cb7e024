"""Degrades detections as of a worse detector: runs of frames without detections, and displaced boxes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.videos.stored_detections import DetectedVideo
from tsr_engine.records import Detections

MEAN_MISSED_RUN = 5.0
"""Mean length of a run of frames without detections."""


@dataclass(frozen=True, slots=True)
class Degradation:
    """Degree of degradation.

    Attributes:
        missed: share of the frames without detections, in [0, 1), in runs of ``MEAN_MISSED_RUN`` frames on average.
        jitter: standard deviation of each edge of a box, share of the width or height.
    """

    missed: float = 0.0
    jitter: float = 0.0


def degrade(seen: DetectedVideo, how: Degradation, seed: int) -> DetectedVideo:
    """The video with fewer detections, whose boxes have normally distributed errors.

    The random numbers are the same for every ``how``, so that a larger value adds to the effect of a smaller one.

    Args:
        seen: the video with its detections.
        how: degree of degradation.
        seed: random seed.
    """
    rng = np.random.default_rng(seed)
    miss_probability = how.missed / (MEAN_MISSED_RUN * (1.0 - how.missed))
    is_missed = bool(rng.random() < how.missed)
    frames = []
    for frame in seen.frames:
        found = frame.detections
        chance, errors = rng.random(), rng.normal(size=(len(found), 4))
        is_missed = bool(chance >= 1 / MEAN_MISSED_RUN) if is_missed else bool(chance < miss_probability)
        sizes = np.tile(found.boxes[:, 2:] - found.boxes[:, :2], 2)
        moved = Detections(found.boxes + how.jitter * errors * sizes, found.raw_scores, found.prior, found.scores)
        frames.append(replace(frame, detections=Detections.empty() if is_missed else moved))
    return replace(seen, frames=tuple(frames))


def bisect_increasing(wanted: float, measured: Callable[[float], float], high: float, steps: int = 7) -> float:
    """The smallest value in [0, ``high``] at which an increasing figure reaches a wanted one, by bisection.

    Args:
        wanted: the wanted figure.
        measured: computes the figure from a value.
        high: largest value; the result if the figure is not reached.
        steps: number of bisections.
    """
    if measured(high) < wanted:
        return high
    low = 0.0
    for _ in range(steps):
        middle = (low + high) / 2
        low, high = (low, middle) if measured(middle) >= wanted else (middle, high)
    return high
