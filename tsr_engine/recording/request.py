"""Defines the request for a recording, and the report on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video_limits import VideoLimits
from tsr_engine.labels.classes import RunClasses
from tsr_engine.recording.content import BoxRows


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """A request to write a recording.

    Attributes:
        evidence: folder of the run.
        out: the ``.rrd`` file; an existing one is replaced.
        first: first frame; unset: the run's first.
        stop: frame after the last; unset: after the run's last.
        video: the video that was tracked; unset: no picture.
        table: its frame table; unset: not known.
        known: whether the caller has just verified the video, which saves hashing a large file.
        exact: whether to copy the video's packets however many bytes they take.
        corrected: the corrected annotation.
        truth: ground truth.
        focus_frame: frame to mark on the time panel.
        focus_track: track whose lines come first.
        name: name for people; unset: made from video and frames.
        notes: further facts for the page "About".
        called: the run's name in error sentences; unset: its folder.
        limits: limits on the video; unset: ``VideoLimits()``.
        classes: mapping from the run's class numbers to the label set of ``corrected`` and ``truth``; unset:
            ``gtsrb-43``.
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
        recording_id: the id by which viewers identify it; equal content has an equal id.
        application_id: the other part of the id.
        name: name for people.
        first: first frame.
        stop: frame after the last.
        size: size in bytes.
        picture_size: size of its pictures in bytes.
        seconds: time of writing, without loading the program.
        picture: origin of the picture, or the reason why there is none.
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
