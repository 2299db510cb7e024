"""Parameters of the offline detector and its spatial prior."""

from __future__ import annotations

from pydantic import Field

from tsr_engine.params.base import Section


class DetectorParams(Section):
    """The scan of one picture."""

    min_width: float = Field(16.0, ge=8, le=256, description="width of the narrowest sign searched for, px")
    keep_score: float = Field(
        -2.0, description="detections with a raw score below this are dropped, also from evidence"
    )
    beyond_edge: float = Field(
        0.25, ge=0, le=0.5, description="share of a sign's width or height that may lie beyond the picture's edge"
    )
    dense_trees: int = Field(24, ge=1, le=64, description="trees evaluated for whole rows before windows are dropped")
    first_overlap: float = Field(
        0.5,
        gt=0,
        le=1,
        description="overlap for suppression before the refine-and-verify stage, share of the smaller box",
    )
    final_overlap: float = Field(
        0.5,
        gt=0,
        le=1,
        description="overlap for suppression after the refine-and-verify stage, share of the smaller box",
    )
    refine_limit: int = Field(
        16, ge=1, le=500, description="largest number of candidates in a picture for the refine-and-verify stage"
    )
    far_share: float = Field(0.045, ge=0, le=1, description="signs narrower than this share of the height are far away")
    far_top: float = Field(0.2, ge=0, le=1, description="far signs are searched below this share of the height")
    far_bottom: float = Field(0.84, ge=0, le=1, description="far signs are searched above this share of the height")
    refine_passes: int = Field(2, ge=0, le=8, description="number of passes of the box refinement (0: none)")
    inset_width: float = Field(
        0.96, ge=0.5, le=2, description="factor on the width of boxes: the training scenes leave a margin around signs"
    )
    inset_height: float = Field(0.94, ge=0.5, le=2, description="factor on the height of boxes, likewise")
    inset_rise: float = Field(0.01, ge=-0.2, le=0.2, description="boxes are moved up by this share of their height")
    scan_turns: int = Field(
        1,
        ge=1,
        le=12,
        description="frames over which the scan of a picture is spread: a new sign is found up to scan_turns "
        "- 1 frames later. Frame 0 is scanned whole, and tracked signs are detected in each frame (1: each frame is "
        "scanned whole)",
    )
    second_core: bool = Field(True, description="use a second core for the scan when there is one")


class PriorParams(Section):
    """The spatial prior (Eq. 2)."""

    use_prior: bool = Field(True, description="add (P_spatial - 1/2) * lambda to the raw score")
    prior_lambda: float | None = Field(None, ge=0, description="lambda of Eq. 2; unset: the value learned by Eq. 8")
