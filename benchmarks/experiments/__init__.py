"""The experiments, in the order of the report."""

from __future__ import annotations

from benchmarks.experiment import Experiment
from benchmarks.experiments import (
    ablations,
    clips,
    deep,
    detection,
    detection_video,
    exports,
    follow,
    frame_rates,
    fusion,
    gaps,
    gate,
    misses,
    prior,
    recordings,
    retraining,
    review,
    review_hour,
    scale,
    search,
    speed,
    stress,
    svm,
    systems,
    trackers,
    yolo_time,
)

__all__ = ["EXPERIMENTS"]

EXPERIMENTS: tuple[Experiment, ...] = (
    prior.EXPERIMENT,
    gate.EXPERIMENT,
    systems.EXPERIMENT,
    detection.EXPERIMENT,
    detection_video.EXPERIMENT,
    deep.EXPERIMENT,
    misses.EXPERIMENT,
    clips.EXPERIMENT,
    stress.EXPERIMENT,
    ablations.EXPERIMENT,
    trackers.EXPERIMENT,
    frame_rates.EXPERIMENT,
    gaps.EXPERIMENT,
    follow.EXPERIMENT,
    fusion.EXPERIMENT,
    svm.EXPERIMENT,
    speed.EXPERIMENT,
    yolo_time.EXPERIMENT,
    scale.EXPERIMENT,
    search.EXPERIMENT,
    retraining.EXPERIMENT,
    exports.EXPERIMENT,
    recordings.EXPERIMENT,
    review.EXPERIMENT,
    review_hour.EXPERIMENT,
)
