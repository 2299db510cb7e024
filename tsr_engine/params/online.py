"""Parameters of the online detector (Algorithms 1 and 2)."""

from __future__ import annotations

from pydantic import Field

from tsr_engine.params.base import Section


class OnlineParams(Section):
    """Incremental SVM and relocalisation."""

    use_online: bool = Field(
        True, description="relocalise with the online detector when the gate rejects (off: KF alone)"
    )
    search_radius: int = Field(20, ge=1, le=100, description="n of Algorithm 2, px on each side of the prediction")
