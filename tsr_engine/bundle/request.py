"""Defines the request for a bundle, and the report on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from tsr_engine.bundle.expectation import Expectation
from tsr_engine.bundle.judge import Finding
from tsr_engine.bundle.manifest import Manifest
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import VideoLimits
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.labels.classes import RunClasses

if TYPE_CHECKING:
    from tsr_engine.recording import BoxRows


@dataclass(frozen=True, slots=True)
class BundleRequest:
    """A request to make a bundle.

    Attributes:
        evidence: folder of the run.
        video: the video that was tracked.
        out: the ZIP file; an existing one is replaced at the end.
        first: first judged frame.
        stop: frame after the last judged one.
        note: text of the reporter.
        expectation: the expected results.
        corrections: the corrected tracks as the tool stores them, plain JSON values.
        corrected: the corrected tracks as boxes, for the recording.
        classes: mapping from the run's class numbers to the label set of the corrections; unset: ``gtsrb-43``.
        tracks: keys of the tracks that the report is about.
        table: the video's frame table; unset: not known.
        limits: limits on the video.
        models: model folders in which to search for the run's models.
        network: file of the run's ONNX network, to put in.
        run_id: the tool's id of the run.
        run_name: name of the run.
        preset: preset of the run.
        kind: ``engine`` or ``whatif``.
        recording: whether to add a recording, if one can be made.
    """

    evidence: Path
    video: VideoSource
    out: Path
    first: int
    stop: int
    note: str = ""
    expectation: Expectation = field(default_factory=Expectation)
    corrections: JsonMapping = field(default_factory=lambda: {"documents": []})
    corrected: BoxRows | None = None
    classes: RunClasses | None = None
    tracks: tuple[str, ...] = ()
    table: FrameTable | None = None
    limits: VideoLimits | None = None
    models: Sequence[Path] = ()
    network: Path | None = None
    run_id: str = ""
    run_name: str = ""
    preset: str = ""
    kind: str = "engine"
    recording: bool = True


@dataclass(frozen=True, slots=True)
class BundleReport:
    """The report on a new bundle: its verdicts on the run's output, and warnings for the maker."""

    path: Path
    size: int
    manifest: Manifest
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...]
