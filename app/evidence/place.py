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

__all__ = ["RunPlace"]


@dataclass(frozen=True, slots=True)
class RunPlace:
    """Where a run's evidence lies and how the run stands."""

    id: str
    video_id: str
    folder: Path
    state: str
    parent_id: str | None
    preset: str
    parameters: JsonObject
    classes: RunClasses
    """What the class numbers of the evidence mean in the newest version of the video's label set."""

    @property
    def complete(self) -> bool:
        """Nothing will be added any more."""
        return self.state == "complete"

    @property
    def begun(self) -> bool:
        """The run has stored something."""
        return (self.folder / RUN_FILE).is_file()

    def readable(self) -> bool:
        """Whether the run has stored anything yet.

        Raises:
            Conflict: it has stored all of it, and that is gone.
        """
        if self.complete and not self.begun:
            raise Conflict(f"The run's evidence is not there any more. Put {self.folder} back.", code="evidence_gone")
        return self.begun

    @property
    def tau(self) -> float:
        """Threshold of the gate that the run was asked for; the usual one where a newer version wrote it."""
        try:
            return Params.preset(self.preset).with_settings(self.parameters.items()).gate.tau
        except EvidenceError:
            return Params().gate.tau
