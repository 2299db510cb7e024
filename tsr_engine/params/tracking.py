"""Parameters of motion, association, birth and death."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tsr_engine.params.base import Section


class TrackingParams(Section):
    """Motion model, association of detections to tracks, track life cycle."""

    motion: Literal["paper", "constant_velocity", "looming"] = Field("looming", description="motion model")
