"""Parameters of the fusion of class votes over a track (Eq. 4, 5)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tsr_engine.params.base import Section


class FusionParams(Section):
    """Weights of the frames of one physical sign."""

    fusion_mode: Literal["scale", "equal", "clamped"] = Field(
        "clamped",
        description="scale: Eq. 5; clamped: Eq. 5 with full weight above fusion_scale; equal: the same weight "
        "for all frames",
    )
    fusion_delta: float = Field(20.0, ge=0.1, le=1000, description="delta of Eq. 5, px")
    fusion_scale: float = Field(48.0, gt=0, le=1000, description="s_c of Eq. 5, px")
