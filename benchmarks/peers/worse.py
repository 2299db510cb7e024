"""A video as a worse detector would have seen it: runs of frames without detections, and boxes that are off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.peers.seen import Seen
from tsr_engine.records import Detections

__all__ = ["RUN", "Worse", "reaching", "worsened"]

RUN = 5.0
"""Mean length of a run of frames without detections."""


@dataclass(frozen=True, slots=True)
class Worse:
    """How much worse.

    Attributes:
        missed: share of the frames in which nothing is detected, in [0, 1). They come in runs of ``RUN`` frames on
            average.
        jitter: standard deviation of each edge of a box, share of the width or height.
    """

    missed: float = 0.0
    jitter: float = 0.0


def worsened(seen: Seen, how: Worse, seed: int) -> Seen:
    """The same video with fewer detections, whose boxes are off by normal errors.

    The random numbers are the same for every ``how``: more of the same happens where it asks for more.

    Args:
        seen: the video with its detections.
        how: see :class:`Worse`.
        seed: of everything random.
    """
    rng = np.random.default_rng(seed)
    again = how.missed / (RUN * (1.0 - how.missed))
    gone = bool(rng.random() < how.missed)
    frames = []
    for frame in seen.frames:
        found = frame.detections
        chance, off = rng.random(), rng.normal(size=(len(found), 4))
        gone = bool(chance >= 1 / RUN) if gone else bool(chance < again)
        sizes = np.tile(found.boxes[:, 2:] - found.boxes[:, :2], 2)
        moved = Detections(found.boxes + how.jitter * off * sizes, found.raw_scores, found.prior, found.scores)
        frames.append(replace(frame, detections=Detections.empty() if gone else moved))
    return replace(seen, frames=tuple(frames))


def reaching(wanted: float, measured: Callable[[float], float], high: float, steps: int = 7) -> float:
    """The least value in [0, ``high``] at which something that grows with it reaches a figure, by halving.

    Args:
        wanted: the figure.
        measured: value -> figure.
        high: largest value; the answer where the figure is not reached.
        steps: number of halvings.
    """
    if measured(high) < wanted:
        return high
    low = 0.0
    for _ in range(steps):
        middle = (low + high) / 2
        low, high = (low, middle) if measured(middle) >= wanted else (middle, high)
    return high
