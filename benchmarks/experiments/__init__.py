"""The experiments, in the order of the report."""

from __future__ import annotations

from benchmarks.experiment import Experiment
from benchmarks.experiments import clips, detection, fusion, gate, prior, review, speed, stress, svm

__all__ = ["EXPERIMENTS"]

EXPERIMENTS: tuple[Experiment, ...] = (
    prior.EXPERIMENT,
    gate.EXPERIMENT,
    detection.EXPERIMENT,
    clips.EXPERIMENT,
    stress.EXPERIMENT,
    fusion.EXPERIMENT,
    svm.EXPERIMENT,
    speed.EXPERIMENT,
    review.EXPERIMENT,
)
