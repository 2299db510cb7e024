"""Request, progress and report of a live run."""

from __future__ import annotations

from array import array
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.params import Params
from tsr_engine.pipeline import TrackSummary
from tsr_engine.recognition.gtsrb_classes import CLASS_NAMES
from tsr_engine.tracking.focus_of_expansion import Focus


@dataclass(frozen=True, slots=True)
class RunRequest:
    """The request of a run: its input, parameters and outputs.

    Attributes:
        video: the file.
        params: all parameters.
        evidence: folder of the evidence; unset: no evidence.
        csv: file of the result rows; unset: none.
        annotated: file of the annotated video; unset: none.
        start: first frame.
        stop: frame after the last; unset: the end of the video.
        restart: whether to replace a run that the evidence folder holds.
        table: the video's frame table from an earlier pass, for fast access to a start in the middle.
        limits: limits on the video; unset: ``VideoLimits()``.
        shared: whether other machines read the evidence while it is written.
        cores: number of processes that detect frames, >= 1, this one included; results are the same bytes for any
            number.
    """

    video: VideoSource
    params: Params
    evidence: Path | None = None
    csv: Path | None = None
    annotated: Path | None = None
    start: int = 0
    stop: int | None = None
    restart: bool = False
    table: FrameTable | None = None
    limits: VideoLimits | None = None
    shared: bool = False
    cores: int = 1


@dataclass(frozen=True, slots=True)
class Progress:
    """The progress of a run."""

    done: int
    """Number of frames done, including earlier calls."""
    total: int | None
    """Number of frames to do; None: unknown."""
    rate: float | None
    """Frames per second of this call, without the first frame, which compiles kernels; None: only one frame so far."""
    remaining: float | None
    """Remaining seconds at that rate; None: unknown."""


@dataclass(slots=True)
class RunReport:
    """The report on a run."""

    video: str
    width: int
    height: int
    frames: int = 0
    """Number of frames with results, including earlier calls."""
    first_frame: int = 0
    resumed_at: int | None = None
    """First frame of this call if it resumed a run."""
    interrupted: bool = False
    seconds: float = 0.0
    """Wall time of this call."""
    params: Params = field(default_factory=Params)
    """Parameters of the run, including its camera's focus."""
    focus: Focus | None = None
    """Focus of expansion of the camera, if this call estimated it."""
    focus_seconds: float = 0.0
    """Wall time of the estimation, s, not part of ``seconds``."""
    first_seconds: float = 0.0
    """Part of ``seconds`` up to the end of the first frame; later frames find models loaded and kernels compiled."""
    computed: int = 0
    """Number of frames that this call computed."""
    tracks: list[TrackSummary] = field(default_factory=list)
    events: Counter[str] = field(default_factory=Counter)
    """Number of events by kind."""
    stages: dict[str, array[float]] = field(default_factory=dict)
    """Stage -> seconds for each frame of this call that went through it."""
    warnings: tuple[str, ...] = ()
    class_names: tuple[str, ...] = CLASS_NAMES
    """Display name of each class."""

    def rate(self, seconds: float | None = None) -> float | None:
        """Frames per second of this call without its first frame; None: there are no others.

        Args:
            seconds: wall time of this call up to now; unset: that of the finished call.
        """
        spent = (self.seconds if seconds is None else seconds) - self.first_seconds
        return None if self.computed < 2 or spent <= 0 else (self.computed - 1) / spent

    def stage_table(self) -> list[tuple[str, int, float, float]]:
        """Rows ``(stage, frames, median ms, 95th percentile ms)``."""
        return [
            (stage, len(seconds), float(np.median(seconds)) * 1e3, float(np.percentile(seconds, 95)) * 1e3)
            for stage, seconds in self.stages.items()
        ]
