"""The frame loop of Algorithm 3, and what surrounds it in a live run and in a replay."""

from tsr_engine.pipeline.ahead import Detected, detected_ahead
from tsr_engine.pipeline.companion import OnlineLearner, OnlineMaker, Parts
from tsr_engine.pipeline.components import (
    Components,
    Network,
    load_classifier,
    load_components,
    load_detector,
    load_online,
)
from tsr_engine.pipeline.core import TrackingCore
from tsr_engine.pipeline.frame import FrameInput
from tsr_engine.pipeline.kept import keep_regions
from tsr_engine.pipeline.results import ResultStream, TrackSummary
from tsr_engine.pipeline.stored import RECOMPUTED, input_of, rebuild, rescored, start_core
from tsr_engine.pipeline.threads import one_blas_thread

__all__ = [
    "RECOMPUTED",
    "Components",
    "Detected",
    "FrameInput",
    "Network",
    "OnlineLearner",
    "OnlineMaker",
    "Parts",
    "ResultStream",
    "TrackSummary",
    "TrackingCore",
    "detected_ahead",
    "input_of",
    "keep_regions",
    "load_classifier",
    "load_components",
    "load_detector",
    "load_online",
    "one_blas_thread",
    "rebuild",
    "rescored",
    "start_core",
]
