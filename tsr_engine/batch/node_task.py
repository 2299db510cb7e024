"""Defines the task of doing one run of the server on a node."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tsr_engine.runs.report import RunRequest
from tsr_engine.version import __version__


@dataclass(frozen=True, slots=True)
class NodeTask:
    """A run for a node; sent pickled.

    Attributes:
        request: the run; all nodes see its files under the same names.
        models: folder of models; None: the shipped ones.
        digests: component -> SHA-256 that the models must have.
        memory_mb: limit on the process's address space, MiB; 0: no limit.
        version: version of tsr that the node must have.
    """

    request: RunRequest
    models: Path | None
    digests: dict[str, str]
    memory_mb: int = 0
    version: str = __version__
