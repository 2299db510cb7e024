"""Parameters of the gate (Eq. 3)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tsr_engine.params.base import Section


class GateParams(Section):
    """Conditions for a confident prediction."""

    tau: float = Field(15.0, gt=0, le=1e6, description="a prediction is confident if L_positive < tau")
    gate_margin: float = Field(
        0.1, ge=0, le=1, description="border of the gate's crops on each side, share of the box's side"
    )
    symmetry_size: int = Field(48, ge=32, le=256, description="side that crops are resized to for symmetry, px")
    symmetry_contrast: float = Field(
        0.003, ge=0, le=0.5, description="contrast below which SIFT features do not count for symmetry"
    )
    symmetry_floor: float = Field(0.6, gt=0, le=1, description="smallest magnitude used in the reciprocal")
    hash_memory: int | None = Field(
        5, ge=1, le=1000, description="the newest crop weighs at least 1/this in the mean picture; none: plain mean"
    )
    position_unit: Literal["px", "side"] = Field("side", description="p_pos in px, or in sides of the candidate")
    position_camera: bool = Field(
        True, description="subtract the measured global shift of the picture since the previous frame from p_pos"
    )
    position_offset: float = Field(
        0.0,
        ge=0,
        le=1000,
        description="added to p_pos in the product, so that the appearance of a smoothly moving prediction counts too",
    )
