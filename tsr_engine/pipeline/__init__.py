"""The frame loop of Algorithm 3, and its inputs and results in live runs and replays."""

from tsr_engine.pipeline.ahead import Detected, detected_ahead
from tsr_engine.pipeline.components import (
    Components,
    Network,
    load_components,
    load_detector,
    load_online,
    load_other_shapes,
)
from tsr_engine.pipeline.core import TrackingCore
from tsr_engine.pipeline.detecting import VideoDetector
from tsr_engine.pipeline.frame import FrameInput
from tsr_engine.pipeline.readers import READING, load_reader, reader_of
from tsr_engine.pipeline.replay_regions import replay_regions
from tsr_engine.pipeline.results import ResultStream, TrackSummary
from tsr_engine.pipeline.stored import RECOMPUTED, input_of, rebuild, rescored, start_core
from tsr_engine.pipeline.threads import one_blas_thread, one_opencv_thread
from tsr_engine.pipeline.track_context import Models, OnlineLearner, OnlineMaker

__all__ = [
    "READING",
    "RECOMPUTED",
    "Components",
    "Detected",
    "FrameInput",
    "Models",
    "Network",
    "OnlineLearner",
    "OnlineMaker",
    "ResultStream",
    "TrackSummary",
    "TrackingCore",
    "VideoDetector",
    "detected_ahead",
    "input_of",
    "load_components",
    "load_detector",
    "load_online",
    "load_other_shapes",
    "load_reader",
    "one_blas_thread",
    "one_opencv_thread",
    "reader_of",
    "rebuild",
    "replay_regions",
    "rescored",
    "start_core",
]
