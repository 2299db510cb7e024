"""Detections over a video, with or without the Kalman filter, compared with ground truth."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.boxes import share_inside
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.protocols import OfflineDetector
from tsr_engine.records import Detections, FloatArray
from tsr_engine.track_table import TrackTable
from tsr_engine.tracking.camera_shift import CameraShift
from tsr_engine.tracking.tracker import Tracker

__all__ = [
    "FrameDetections",
    "FrameGroundTruth",
    "Rows",
    "detect_video",
    "frame_ground_truths",
    "track_with_filter",
    "without_ignored",
]


@dataclass(frozen=True, slots=True)
class FrameDetections:
    """Detections in one frame.

    Attributes:
        ordinal: ordinal of the frame.
        seconds: presentation time.
        size: width and height, px.
        shift: global camera shift since the last frame, px.
        detections: detections, best first.
    """

    ordinal: int
    seconds: float
    size: tuple[int, int]
    shift: tuple[float, float]
    detections: Detections


@dataclass(frozen=True, slots=True)
class FrameGroundTruth:
    """Counted signs of one frame, (n, 4), and ignored boxes, (m, 4)."""

    boxes: FloatArray
    ignored: FloatArray


@dataclass(frozen=True, slots=True)
class Rows:
    """Tracked boxes of one frame.

    Attributes:
        boxes: shape (n, 4), boxes of tracks that are confirmed in any frame.
        scores: shape (n,).
        known: shape (n,), whether the track is already confirmed.
    """

    boxes: FloatArray
    scores: FloatArray
    known: NDArray[np.bool_]


def detect_video(video: Path, detector: OfflineDetector, times: list[float]) -> Iterator[FrameDetections]:
    """Run a detector over a video.

    Args:
        video: the file.
        detector: any detector.
        times: receives the CPU seconds of this thread for each detection.
    """
    tracking = Params().tracking
    shift = CameraShift(tracking.shift_scale, (tracking.foe_x, tracking.foe_y))
    with open_video(video) as opened:
        for frame in opened.frames():
            if not times:
                detector.detect(frame.picture)  # may compile
            began = time.thread_time()
            found = detector.detect(frame.picture)
            times.append(time.thread_time() - began)
            size = (frame.picture.shape[1], frame.picture.shape[0])
            yield FrameDetections(frame.ordinal, frame.seconds, size, shift.step(frame.picture), found)


def track_with_filter(frames: Sequence[FrameDetections], params: TrackingParams) -> list[Rows]:
    """Track the frames' detections with the Kalman filter alone, without gate and online detector."""
    if not frames:
        return []
    tracker = Tracker(params, *frames[0].size)
    gaps = np.diff([frame.seconds for frame in frames])
    interval = float(np.median(gaps)) if len(gaps) else 1.0
    raw: list[list[tuple[int, bool, FloatArray, float]]] = []
    confirmed: set[int] = set()
    before: float | None = None
    for frame in frames:
        dt = 1.0 if before is None else max(1e-3, (frame.seconds - before) / max(interval, 1e-9))
        before = frame.seconds
        tracks = tracker.step(frame.ordinal, frame.detections, dt, frame.shift).tracks
        raw.append([(t.track_id, t.state == "confirmed", t.box, t.score) for t in tracks])
        confirmed |= {t.track_id for t in tracks if t.state == "confirmed"}
    out = []
    for rows in raw:
        kept = [row for row in rows if row[0] in confirmed]
        out.append(
            Rows(
                np.array([row[2] for row in kept], float).reshape(-1, 4),
                np.array([row[3] for row in kept], float),
                np.array([row[1] for row in kept], bool),
            )
        )
    return out


def frame_ground_truths(truth: TrackTable, ordinals: Sequence[int], min_width: float) -> list[FrameGroundTruth]:
    """Ground truth by frame; signs narrower than ``min_width`` px are ignored."""
    counts = ~truth.ignore & (truth.boxes[:, 2] - truth.boxes[:, 0] >= min_width)
    return [
        FrameGroundTruth(truth.boxes[(truth.frame == k) & counts], truth.boxes[(truth.frame == k) & ~counts])
        for k in ordinals
    ]


def without_ignored(
    boxes: FloatArray, scores: FloatArray, truth: FrameGroundTruth
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Boxes, scores and ground truth, without boxes that an ignored box excuses and that are on no counted sign.

    An ignored box excuses a box with an IoU of at least 0.5, or with at least half of its area inside.
    """
    if len(boxes) and len(truth.ignored):
        excused = (np.maximum(iou(boxes, truth.ignored), share_inside(boxes, truth.ignored)) >= 0.5).any(axis=1)
        if len(truth.boxes):
            excused &= ~(iou(boxes, truth.boxes) >= 0.5).any(axis=1)
        boxes, scores = boxes[~excused], scores[~excused]
    return boxes, scores, truth.boxes
