"""Detections of a sign that comes nearer, and a tracker that follows them."""

from __future__ import annotations

import numpy as np

from tsr_engine.params.tracking import TrackingParams
from tsr_engine.records import Detections
from tsr_engine.tracking.track_status import TrackedFrame
from tsr_engine.tracking.tracker import Tracker

__all__ = ["HEIGHT", "PARAMS", "WIDTH", "approach", "detections", "event_kinds", "run_tracker"]

WIDTH, HEIGHT = 720, 576
PARAMS = TrackingParams()


def detections(*rows: tuple[float, float, float, float, float]) -> Detections:
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    scores = table[:, 4]
    return Detections(table[:, :4], scores, np.full(len(table), 0.5), scores)


def approach(frame: int, score: float = 2.0, offset: float = 0.0) -> tuple[float, float, float, float, float]:
    """A sign that looms, to the upper right of the FOE."""
    w = 20.0 / (1.0 - 0.015 * frame)
    x, y = WIDTH / 2 + 3 * w + offset, HEIGHT / 2 - 2 * w
    return (x, y, x + w, y + w, score)


def run_tracker(tracker: Tracker, frames: dict[int, Detections], count: int) -> list[TrackedFrame]:
    return [tracker.step(f, frames.get(f, Detections.empty())) for f in range(count)]


def event_kinds(frame: TrackedFrame) -> list[str]:
    return [event.kind for event in frame.events]
