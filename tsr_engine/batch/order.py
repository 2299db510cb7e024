"""The order to a process about one drive, and its outcome; both are JSON."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from tsr_engine.json_shapes import JsonObject

__all__ = ["Order", "Outcome"]


@dataclass(frozen=True)
class Order:
    """One drive to track.

    Attributes:
        video: absolute path.
        folder: where the results go, absolute; it appears when they are whole.
        parameters: of ``Params``, as JSON.
        models: folder of models; None: those that ship with the package.
        digests: component -> SHA-256 that these models must have.
        onnx: arguments of ``tsr_engine.pipeline.Network``; None: no network.
        evidence, csv, annotated: which results are kept.
        start, stop: first frame, and the frame after the last; None: to the end.
        cores: processes that detect frames.
        memory_mb: address space that the process may use, MiB; 0: any.
        stamp: written into the results: whose they are, see ``tsr_engine.batch.run``.
    """

    video: str
    folder: str
    parameters: JsonObject
    models: str | None = None
    digests: dict[str, str] = field(default_factory=dict)
    onnx: list[Any] | None = None
    evidence: bool = True
    csv: bool = True
    annotated: bool = False
    start: int = 0
    stop: int | None = None
    cores: int = 1
    memory_mb: int = 0
    stamp: str = ""

    def as_json(self) -> JsonObject:
        """For another process."""
        return asdict(self)


@dataclass(frozen=True)
class Outcome:
    """The outcome of an order.

    Attributes:
        result: figures; None: it failed.
        error: one sentence; empty: it went well.
        died: the process ended without a word, so that another try may go better.
    """

    result: JsonObject | None
    error: str = ""
    died: bool = False
