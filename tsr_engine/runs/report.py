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
from tsr_engine.recognition.catalogue import CLASS_NAMES
from tsr_engine.tracking.focus import Focus

__all__ = ["Progress", "RunReport", "RunRequest"]


@dataclass(frozen=True, slots=True)
class RunRequest:
    """The request: what to track, and where the results go.

    Attributes:
        video: the file.
        params: all parameters.
        evidence: folder of the evidence store; unset: none is kept.
        csv: file of the result rows; unset: none.
        annotated: file of the annotated video; unset: none.
        start: first frame.
        stop: frame after the last; unset: to the end.
        restart: start over where the evidence folder already holds a run.
        table: the video's frame table from an earlier pass: a start in the middle is then reached at once.
        limits: what the video may demand; unset: ``VideoLimits()``.
        shared: other machines read the evidence while it is written.
        cores: processes that detect frames, >= 1, this one counted; the results are the same bytes for any number.
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
    """Frames done, those of an earlier part of the run included."""
    total: int | None
    """Frames to do, as far as it is known."""
    rate: float | None
    """Frames a second of this call after its first, which waits for kernels; None: there is only that one."""
    remaining: float | None
    """Seconds left at that rate."""


@dataclass(slots=True)
class RunReport:
    """The report on a run."""

    video: str
    width: int
    height: int
    frames: int = 0
    """Frames with results, those of an earlier part of the run included."""
    first_frame: int = 0
    resumed_at: int | None = None
    """First frame of this call if an earlier one was continued."""
    interrupted: bool = False
    seconds: float = 0.0
    """Wall time of this call."""
    params: Params = field(default_factory=Params)
    """Parameters of the run, its camera's focus among them."""
    focus: Focus | None = None
    """Where the camera looks, if the drive told it in this call."""
    focus_seconds: float = 0.0
    """Wall time that this took, before ``seconds``."""
    first_seconds: float = 0.0
    """... of which until its first frame was done: models are warm and kernels compiled from then on."""
    computed: int = 0
    """Frames computed by this call."""
    tracks: list[TrackSummary] = field(default_factory=list)
    events: Counter[str] = field(default_factory=Counter)
    """Events by kind."""
    stages: dict[str, array[float]] = field(default_factory=dict)
    """Stage -> seconds of each frame that went through it, in this call."""
    warnings: tuple[str, ...] = ()
    class_names: tuple[str, ...] = CLASS_NAMES
    """What people read for each class number."""

    def rate(self, seconds: float | None = None) -> float | None:
        """Frames a second after the first frame of this call; None: nothing came after it.

        Args:
            seconds: wall time of this call so far; unset: it is over.
        """
        spent = (self.seconds if seconds is None else seconds) - self.first_seconds
        return None if self.computed < 2 or spent <= 0 else (self.computed - 1) / spent

    def stage_table(self) -> list[tuple[str, int, float, float]]:
        """Rows ``(stage, frames, median ms, 95th percentile ms)``."""
        return [
            (stage, len(seconds), float(np.median(seconds)) * 1e3, float(np.percentile(seconds, 95)) * 1e3)
            for stage, seconds in self.stages.items()
        ]
