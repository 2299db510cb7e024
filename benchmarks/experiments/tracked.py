"""Runs of the whole engine over annotated clips, scored; shared by the experiments on clips."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from tsr_engine.evaluation.tracking import VideoReport, evaluate_video
from tsr_engine.evaluation.tracking_rows import Truth, read_results
from tsr_engine.params import Params
from tsr_engine.pipeline import load_components
from tsr_engine.runs import RunRequest, track_video

__all__ = ["CONFIGURATIONS", "score"]

CONFIGURATIONS: Mapping[str, Params] = {
    "default": Params.preset("default"),
    "KF alone": Params.preset("default").with_settings([("use_online", False)]),
    "paper": Params.preset("paper"),
}
"""What is compared: as shipped; without the online detector; the paper's own numbers."""


def score(videos: Mapping[str, tuple[Path, Truth]], params: Params) -> tuple[list[VideoReport], float]:
    """Track and score videos.

    Returns:
        A report of each, and the wall time a frame in ms.
    """
    components = load_components(params)
    reports, frames, seconds = [], 0, 0.0
    for name, (video, truth) in videos.items():
        with tempfile.TemporaryDirectory() as scratch:
            rows = Path(scratch) / "rows.csv"
            began = time.monotonic()
            run = track_video(RunRequest(video, params, csv=rows), components)
            seconds += time.monotonic() - began
            frames += run.frames
            reports.append(evaluate_video(name, truth, read_results(rows), run.frames))
    return reports, 1e3 * seconds / max(1, frames)
