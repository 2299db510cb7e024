"""Parameters of the frame loop itself: what it does when its parts disagree, and which pixels it keeps."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tsr_engine.params.base import Section


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
        description="from so many frames in a row without a detection on, the online detector is asked whatever the "
        "gate says; none: only when the gate rejects",
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
        description="noise of such a window's width and height, relative to a detection's: few sizes are searched, so "
        "it says little of the sign's (none: as that of its centre)",
    )
    rescore_windows: bool = Field(
        True,
        description="the offline detector rescores such a window: what it takes for a sign there is "
        "measured as a detection of that score would be, edges and all",
    )
    rescore_score: float = Field(2.0, description="least score, before the prior, from which that is taken for a sign")
    rescore_noise: float = Field(
        1.0, gt=0, le=100, description="noise of what rescoring finds, relative to a detection of that score"
    )
    inflate_rejected_noise: bool = Field(
        True,
        description="the less such a window looks like a sign to the window scorer, which rejects it, the less exact "
        "a measurement it is: its noise grows as that of a detection of that score",
    )
    search_sigmas: float | None = Field(
        3.0,
        gt=0,
        le=100,
        description="such a window is refused whose centre lies farther than this from the predicted one, std of a "
        "detection's innovation; none: however far",
    )
    keep_radius: int = Field(
        40, ge=1, le=200, description="largest search_radius that a replay finds pixels for, px around each prediction"
    )
    keep_context: float = Field(
        0.5, ge=0, le=4, description="context kept around each detection for a replay, share of its size"
    )
    network_classifier: bool = Field(
        False,
        description="the network of the models reads signs, not descriptor and feature map: more single frames are "
        "right; it knows the 43 signs alone, since retraining leaves it out",
    )
