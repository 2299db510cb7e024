"""Writes made-up frames as a complete run."""

from __future__ import annotations

from pathlib import Path

from tsr_engine.evidence import EvidenceWriter, RunHeader
from tsr_engine.records import FrameEvidence

__all__ = ["write_complete_run"]


def write_complete_run(folder: Path, header: RunHeader, frames: list[FrameEvidence], chunk: int = 4) -> None:
    with EvidenceWriter.create(folder, header, chunk=chunk) as writer:
        for evidence in frames:
            writer.append(evidence)
