"""Defines the task of tracking one drive in another process, and its outcome; both are JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final

from tsr_engine.json_shapes import JsonObject

REPORT_FILE: Final = "report.json"
"""File of a drive's figures in its folder."""
ANNOTATED_VIDEO: Final = "seen.mp4"
"""Annotated video there."""


@dataclass(frozen=True)
class DriveTask:
    """One drive to track.

    Attributes:
        video: absolute path.
        folder: absolute path of the results, which appears when they are complete.
        parameters: ``Params`` as JSON.
        models: folder of models; None: the shipped ones.
        digests: component -> SHA-256 that the models must have.
        onnx: arguments of ``tsr_engine.pipeline.Network``; None: no network.
        evidence, csv, annotated: whether each result is kept.
        start, stop: first frame, and the frame after the last; None: to the end.
        cores: number of processes that detect.
        memory_mb: limit on the process's address space, MiB; 0: no limit.
        stamp: identifies the results, see ``tsr_engine.batch.run``.
    """

    video: str
    folder: str
    parameters: JsonObject
    models: str | None = None
    digests: dict[str, str] = field(default_factory=dict)
    onnx: list[Any] | None = None  # Any: each argument has a type of its own
    evidence: bool = True
    csv: bool = True
    annotated: bool = False
    start: int = 0
    stop: int | None = None
    cores: int = 1
    memory_mb: int = 0
    stamp: str = ""


@dataclass(frozen=True)
class Outcome:
    """The outcome of a task.

    Attributes:
        result: figures; None: the task failed.
        error: one sentence; empty: success.
        died: whether the process ended without a message, so that another try may succeed.
    """

    result: JsonObject | None
    error: str = ""
    died: bool = False
