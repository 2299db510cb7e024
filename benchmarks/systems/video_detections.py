"""Detections over a video, with or without the Kalman filter, compared with ground truth."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.boxes import share_inside
from benchmarks.videos.engine_tracker import filter_steps
from benchmarks.videos.stored_detections import DetectedFrame
from tsr_engine.geometry.boxes import iou
from tsr_engine.io.video import open_video
from tsr_engine.params import Params
from tsr_engine.params.tracking import TrackingParams
from tsr_engine.protocols import OfflineDetector
from tsr_engine.records import FloatArray
from tsr_engine.track_table import TrackTable
from tsr_engine.tracking.camera_shift import CameraShift


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


def detect_video(video: Path, detector: OfflineDetector, times: list[float]) -> Iterator[DetectedFrame]:
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
            yield DetectedFrame(frame.ordinal, frame.seconds, found, shift.step(frame.picture))


def track_with_filter(frames: Sequence[DetectedFrame], size: tuple[int, int], params: TrackingParams) -> list[Rows]:
    """Track the frames' detections with the Kalman filter alone; ``size`` is the pictures' width and height, px."""
    gaps = np.diff([frame.seconds for frame in frames])
    interval = max(float(np.median(gaps)), 1e-9) if len(gaps) else 1.0
    raw = [tracks for _, tracks in filter_steps(frames, params, size, interval)]
    confirmed = {t.track_id for tracks in raw for t in tracks if t.state == "confirmed"}
    out = []
    for tracks in raw:
        kept = [t for t in tracks if t.track_id in confirmed]
        out.append(
            Rows(
                np.array([t.box for t in kept], float).reshape(-1, 4),
                np.array([t.score for t in kept], float),
                np.array([t.state == "confirmed" for t in kept], bool),
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
