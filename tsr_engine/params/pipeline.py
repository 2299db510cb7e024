"""Parameters of the frame loop itself: what it does when its parts disagree, and which pixels it keeps."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tsr_engine.params.base import Section

Reader = Literal["both", "classifier", "network"]
"""What classifies signs."""


class PipelineParams(Section):
    """The loop of Algorithm 3, and the pixels that evidence keeps for a replay."""

    rejected_measurement: Literal["relocalised", "detection"] = Field(
        "detection",
        description="measurement of a rejected prediction that has a detection: the online detector's window "
        "(Algorithm 3), or the detection",
    )
    relocalise_probability: float = Field(
        0.0, ge=0, le=1, description="least P(y = 1) of a window that replaces a rejected prediction"
    )
    sure_probability: float = Field(
        0.5, ge=0, le=1, description="least P(y = 1) of a relocalisation that counts as evidence of the sign"
    )
    relocalise_after: int | None = Field(
        2,
        ge=1,
        le=1000,
        description="from this many frames in a row without a detection on, the online detector searches "
        "regardless of the gate; none: only if the gate rejects",
    )
    search_probability: float = Field(
        0.5, ge=0, le=1, description="least P(y = 1) of a window that replaces a confident prediction"
    )
    search_noise: float = Field(
        3.0, gt=0, le=100, description="noise of such a window as a measurement, relative to a detection's"
    )
    search_size_noise: float | None = Field(
        16.0,
        gt=0,
        le=1000,
        description="noise of such a window's width and height, relative to a detection's: few sizes are "
        "searched, so the window says little about the size (none: as for its centre)",
    )
    rescore_windows: bool = Field(
        True,
        description="rescore such a window with the offline detector: an accepted sign is measured as a "
        "detection of that score, including its edges",
    )
    rescore_score: float = Field(2.0, description="least raw score from which a rescored window is accepted as a sign")
    rescore_noise: float = Field(
        1.0, gt=0, le=100, description="noise of a rescored box, relative to a detection of that score"
    )
    inflate_rejected_noise: bool = Field(
        True, description="increase the noise of a window that rescoring rejects, as for a detection of that score"
    )
    search_sigmas: float | None = Field(
        3.0,
        gt=0,
        le=100,
        description="reject such a window if its centre is farther than this from the predicted one, std of a "
        "detection's innovation; none: never",
    )
    keep_radius: int = Field(
        40, ge=1, le=200, description="largest search_radius for which evidence keeps pixels, px around each prediction"
    )
    keep_context: float = Field(
        0.5, ge=0, le=4, description="context kept around each detection for a replay, share of its size"
    )
    reader: Reader = Field(
        "both",
        description="what classifies signs: the classifier and the network of the models together (the classifier "
        "alone where the models have no network), or one of them; the network knows only the 43 signs",
    )
