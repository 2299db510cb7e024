"""The frame loop of Algorithm 3, and its inputs and results in live runs and replays."""

from tsr_engine.pipeline.components import (
    Components,
    Network,
    load_components,
    load_detector,
    load_online,
    load_other_shapes,
)
from tsr_engine.pipeline.core import TrackingCore
from tsr_engine.pipeline.detection_process import Detected
from tsr_engine.pipeline.frame_input import FrameInput
from tsr_engine.pipeline.parallel_detection import detect_in_parallel
from tsr_engine.pipeline.replay_regions import replay_regions
from tsr_engine.pipeline.results import ResultStream, TrackSummary
from tsr_engine.pipeline.sign_readers import READER_COMPONENTS, load_reader, make_reader
from tsr_engine.pipeline.stored_input import RECOMPUTED, rebuild_core, rescore, start_core, stored_input
from tsr_engine.pipeline.threads import one_blas_thread, one_opencv_thread
from tsr_engine.pipeline.track_context import Models, OnlineLearner, OnlineMaker
from tsr_engine.pipeline.video_detector import VideoDetector

__all__ = [
    "READER_COMPONENTS",
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
    "detect_in_parallel",
    "load_components",
    "load_detector",
    "load_online",
    "load_other_shapes",
    "load_reader",
    "make_reader",
    "one_blas_thread",
    "one_opencv_thread",
    "rebuild_core",
    "replay_regions",
    "rescore",
    "start_core",
    "stored_input",
]
