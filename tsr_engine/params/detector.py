"""Parameters of the offline detector and its spatial prior."""

from __future__ import annotations

from pydantic import Field

from tsr_engine.params.base import Section


class DetectorParams(Section):
    """The scan of one picture."""

    min_width: float = Field(16.0, ge=8, le=256, description="narrowest sign that is searched for, px")
    keep_score: float = Field(-2.0, description="raw detections below this score are not kept, not even as evidence")
    second_core: bool = Field(True, description="use a second core for the scan when there is one")


class PriorParams(Section):
    """The spatial prior (Eq. 2)."""

    use_prior: bool = Field(True, description="add (P_spatial - 1/2) * lambda to the raw score")
    prior_lambda: float | None = Field(None, ge=0, description="lambda of Eq. 2; unset: as learned by Eq. 8")
