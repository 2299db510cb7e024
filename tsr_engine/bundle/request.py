"""The request for a bundle, and the report on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from tsr_engine.bundle.expectation import Expectation
from tsr_engine.bundle.judge import Finding
from tsr_engine.bundle.manifest import (
    Manifest,
)
from tsr_engine.io.frame_table import FrameTable
from tsr_engine.io.opened_file import VideoSource
from tsr_engine.io.video import VideoLimits
from tsr_engine.json_shapes import JsonMapping
from tsr_engine.labels.classes import RunClasses

if TYPE_CHECKING:
    from tsr_engine.recording import BoxRows

__all__ = ["BundleReport", "BundleRequest"]

_NO_CORRECTIONS: JsonMapping = {"documents": []}


@dataclass(frozen=True, slots=True)
class BundleRequest:
    """The request for a bundle.

    Attributes:
        evidence: folder of the run.
        video: the video that was tracked.
        out: the zip file; one that is there is replaced at the end.
        first: first frame that counts.
        stop: frame after the last.
        note: what the reporter says.
        expectation: what should have come out.
        corrections: the corrected tracks as the tool stores them, plain JSON values.
        corrected: the same as boxes, for the recording.
        classes: what the run's class numbers mean in the label set of the corrections; unset: in ``gtsrb-43``.
        tracks: keys of the tracks that it is about.
        table: the video's frame table, if it is at hand.
        limits: what the video may demand.
        models: model folders in which the run's models may be.
        network: the ONNX network of the run, to be put in.
        run_id: of the run, in the tool.
        run_name: of the run.
        preset: of the run.
        kind: ``engine`` or ``whatif``.
        recording: put a recording in, if it can be made.
    """

    evidence: Path
    video: VideoSource
    out: Path
    first: int
    stop: int
    note: str = ""
    expectation: Expectation = field(default_factory=Expectation)
    corrections: JsonMapping = field(default_factory=lambda: _NO_CORRECTIONS)
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
    """The report on a bundle that was made.

    Attributes:
        path: the file.
        size: bytes.
        manifest: its manifest.
        findings: what became of the expectations in the run's own output.
        warnings: what the maker should know, one sentence each.
    """

    path: Path
    size: int
    manifest: Manifest
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...]
