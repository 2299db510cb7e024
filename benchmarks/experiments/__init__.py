"""The experiments, in the order of the report."""

from __future__ import annotations

from importlib import import_module

from benchmarks.experiment import Experiment

NAMES = (
    "prior", "gate", "systems", "detection", "detection_video", "deep", "yolo", "misses", "other_shapes", "clips",
    "stress", "poor_detections", "first_sight", "drives", "ablations", "trackers", "frame_rates", "gaps", "follow",
    "follow_approaches", "follow_page", "fusion", "network", "readers", "teaching", "teaching_abroad", "svm", "speed",
    "yolo_time", "realtime", "scale", "search", "clients", "retraining", "exports", "recordings", "uncertainty", "day",
    "review", "review_hour",
)  # fmt: skip
"""Modules of this folder; each has an ``EXPERIMENT`` of the same name."""

EXPERIMENTS: tuple[Experiment, ...] = tuple(import_module(f"{__name__}.{name}").EXPERIMENT for name in NAMES)
