"""The folder of a run's evidence, and the state of the run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.errors import Conflict
from app.labels.mapping import RunClasses
from tsr_engine.errors import EvidenceError
from tsr_engine.evidence.schema import RUN_FILE
from tsr_engine.json_shapes import JsonObject
from tsr_engine.params import Params


@dataclass(frozen=True, slots=True)
class StoredRun:
    """The folder of a run's evidence, and the run's state."""

    id: str
    video_id: str
    folder: Path
    state: str
    parent_id: str | None
    preset: str
    parameters: JsonObject
    classes: RunClasses
    """Maps class numbers of the evidence to the newest version of the video's label set."""

    @property
    def complete(self) -> bool:
        """Whether no more data will be added."""
        return self.state == "complete"

    @property
    def has_results(self) -> bool:
        """Whether the run has results."""
        return (self.folder / RUN_FILE).is_file()

    def readable(self) -> bool:
        """Whether the run has results yet.

        Raises:
            Conflict: the run is complete, but its evidence is missing.
        """
        if self.complete and not self.has_results:
            raise Conflict(f"The run's evidence is missing. Put {self.folder} back.", code="evidence_gone")
        return self.has_results

    @property
    def tau(self) -> float:
        """Threshold of the gate in the run's parameters; the default if a newer version wrote them."""
        try:
            return Params.preset(self.preset).with_settings(self.parameters.items()).gate.tau
        except EvidenceError:
            return Params().gate.tau
