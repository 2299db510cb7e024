"""The order to a node for one run of the server."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from tsr_engine.runs.report import RunRequest
from tsr_engine.version import __version__

__all__ = ["RunOrder"]


@dataclass(frozen=True, slots=True)
class RunOrder:
    """A run for a node; it is sent pickled.

    Attributes:
        request: what to track; all its files lie where every node sees them under the same names.
        models: folder of models; None: those that ship with the package.
        digests: component -> SHA-256 that these models must have.
        memory_mb: address space that the process may use, MiB; 0: any.
        version: of tsr, which the node must have as well.
    """

    request: RunRequest
    models: Path | None
    digests: dict[str, str]
    memory_mb: int = 0
    version: str = field(default=__version__)
