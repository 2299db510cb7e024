"""Parameters of the online detector (Algorithms 1 and 2)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from tsr_engine.params.base import Section


class OnlineParams(Section):
    """Incremental SVM and relocalisation."""

    use_online: bool = Field(
        True, description="relocalise with the online detector when the gate rejects (off: KF alone)"
    )
    search_radius: int = Field(20, ge=1, le=100, description="n of Algorithm 2, px on each side of the prediction")
    search_scales: tuple[Annotated[float, Field(ge=0.5, le=2.0)], ...] = Field(
        (0.93, 1.0, 1.07), min_length=1, max_length=9, description="searched sizes, relative to the prediction"
    )
    search_penalty: float = Field(
        0.5, ge=0, le=100, description="decision value lost at a displacement of search_radius, growing with its square"
    )
    search_subpixel: bool = Field(True, description="refine the peak of the response map by a parabola")
    svm_c: float = Field(0.2, gt=0, le=1e6, description="C of the incremental SVM")
    sample_age: int = Field(40, ge=1, le=100000, description="T: samples older than this many frames are unlearned")
    learn_rejected: bool = Field(False, description="learn predictions that the gate rejects as negative samples")
    learn_undetected: bool = Field(
        False, description="learn confident predictions of frames without a detection as the sign"
    )
    background_negatives: int = Field(
        8, ge=0, le=24, description="background windows around a confident result that are learned as negative samples"
    )
