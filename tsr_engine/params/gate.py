"""Parameters of the gate (Eq. 3)."""

from __future__ import annotations

from pydantic import Field

from tsr_engine.params.base import Section


class GateParams(Section):
    """When a prediction is a confident one."""

    tau: float = Field(15.0, gt=0, description="a prediction is confident if L_positive < tau")
