"""The request for a recording, and the report on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.labels.classes import RunClasses
from tsr_engine.recording.content import BoxRows

__all__ = ["RecordingReport", "RecordingRequest"]


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """The request for a recording.

    Attributes:
        evidence: folder of the run.
        out: the ``.rrd`` file; one that is there is replaced.
        first: first frame; unset: the run's first.
        stop: frame after the last; unset: after the run's last.
        video: the video that was tracked; unset: no picture.
        table: its frame table, if it is at hand.
        known: the caller has just made sure that it is the video that was tracked; a large one takes long to hash.
        exact: take the video's own packets over, however many bytes they are.
        corrected: the annotation as people have corrected it.
        truth: ground truth.
        focus_frame: the frame that it is about; marked on the time panel.
        focus_track: the track that it is about; its lines come first.
        name: for people; unset: made from video and frames.
        notes: further facts for the page "About".
        called: what a refusal calls the run, in the middle of a sentence; unset: by its folder.
        limits: what the video may demand; unset: ``VideoLimits()``.
        classes: what the run's class numbers mean in a label set, of which ``corrected`` and ``truth`` have ids; unset:
            in ``gtsrb-43``.
    """

    evidence: Path
    out: Path
    first: int | None = None
    stop: int | None = None
    video: VideoSource | None = None
    table: FrameTable | None = None
    known: bool = False
    exact: bool = False
    corrected: BoxRows | None = None
    truth: BoxRows | None = None
    focus_frame: int | None = None
    focus_track: int | None = None
    name: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)
    called: str = ""
    limits: VideoLimits | None = None
    classes: RunClasses | None = None


@dataclass(frozen=True, slots=True)
class RecordingReport:
    """The report on a recording.

    Attributes:
        path: the file.
        recording_id: name by which viewers know it; equal content has an equal one.
        application_id: the other part of that name.
        name: for people.
        first: first frame.
        stop: frame after the last.
        size: bytes.
        picture_size: bytes of its pictures.
        seconds: that writing it took, without loading this program.
        picture: where the picture comes from, or why there is none.
        boxes: layer -> number of boxes.
        tracks: tracks with lines.
        events: entries of the event log.
    """

    path: Path
    recording_id: str
    application_id: str
    name: str
    first: int
    stop: int
    size: int
    picture_size: int
    seconds: float
    picture: str
    boxes: dict[str, int]
    tracks: tuple[int, ...]
    events: int
