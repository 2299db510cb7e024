"""Parameters of motion, association, birth and death."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from tsr_engine.params.base import Section

_MAX_NOISE_SCALE = 1e6
"""Largest factor on the noise. Such a measurement has no effect; far larger factors overflow."""


class TrackingParams(Section):
    """Motion model, association of detections to tracks, track life cycle.

    Shares are of the box's own width or height; rates are per nominal frame interval.
    """

    motion: Literal["paper", "constant_velocity", "looming"] = Field("looming", description="motion model")

    # Measurement noise, common to all motion models.
    noise_centre: float = Field(0.03, gt=0, le=1, description="std of a detection's centre, share of its size")
    noise_size: float = Field(0.12, gt=0, le=1, description="std of a detection's width and height, share of its size")
    noise_score: float = Field(
        0.15,
        ge=0,
        le=1,
        description="growth of that noise for each unit of score below clear_score, natural logarithm (0: an "
        "uncertain detection is as exact as a sure one)",
    )
    clear_score: float = Field(8.0, description="score from which on the noise of a detection no longer falls")
    result_noise: float = Field(
        0.35,
        gt=0,
        le=1,
        description="factor on that noise for the result box only: below 1 the box follows the detection more "
        "closely than the filter's state does (1: the state's box)",
    )

    open_edges: bool = Field(True, description="do not measure an edge of a box at the picture's edge")

    # motion = "paper"
    displacement_window: int = Field(
        5, ge=1, le=60, description="paper motion: number of last displacements whose mean is the control input B u"
    )
    paper_process: float = Field(0.08, gt=0, le=2, description="paper motion: process std per frame, share of the size")

    # motion = "constant_velocity"
    velocity_process: float = Field(
        0.01, gt=0, le=1, description="constant velocity: acceleration std per frame^2, share of the size"
    )

    # motion = "looming"
    foe_x: float = Field(0.5, ge=-1, le=2, description="focus of expansion, share of the picture's width")
    foe_y: float = Field(0.5, ge=-1, le=2, description="focus of expansion, share of the picture's height")
    coast_foe_y: float | None = Field(
        None,
        ge=-1,
        le=2,
        description="looming: height of the camera's focus of expansion, share of the picture's height, from "
        "which a track without detections moves away; none: estimated from the drive before tracking, or the "
        "track's own if the estimate fails",
    )
    foe_spread: float = Field(
        0.03,
        ge=0,
        le=1,
        description="looming: std of the assumed focus of expansion, share of width and height (0: known)",
    )
    growth_start: float = Field(0.015, ge=-0.2, le=0.5, description="looming: growth per frame assumed at birth")
    growth_spread: float = Field(0.05, gt=0, le=1, description="looming: std of the growth assumed at birth")
    growth_process: float = Field(0.0002, ge=0, le=1, description="looming: std of the change of growth per frame")
    scale_process: float = Field(0.004, ge=0, le=1, description="looming: std of the width's own wander per frame")
    aspect_process: float = Field(0.004, ge=0, le=1, description="looming: std of the aspect ratio's wander per frame")
    centre_process: float = Field(0.05, ge=0, le=2, description="looming: centre wander std per frame, share of size")
    centre_process_px: float = Field(0.3, ge=0, le=50, description="looming: centre wander std per frame, px")
    drift_process: float = Field(0.1, ge=0, le=50, description="looming: std of the drift's change per frame, px")
    drift_decay: float = Field(0.95, ge=0, le=1, description="looming: share of the drift that lasts to the next frame")

    # Camera rotation
    use_camera_shift: bool = Field(True, description="add the picture's global shift (camera rotation) to predictions")
    level_frames: int = Field(
        60,
        ge=0,
        le=10_000,
        description="frames whose mean vertical shift is subtracted, as the effect of a camera that is not "
        "level (0: none)",
    )
    shift_scale: int = Field(4, ge=1, le=16, description="the global shift is estimated at 1 / this scale")

    # Association
    low_score: float = Field(-2.0, description="detections below this score are never associated")
    high_score: float = Field(0.0, description="detections from this score on are associated first")
    iou_gate: float = Field(0.2, ge=0, le=1, description="least IoU of prediction and detection for a match by overlap")
    centre_gate: float = Field(
        0.8, ge=0, le=5, description="largest centre distance for a match without overlap, share of the size"
    )
    gate_sigmas: float = Field(
        3.0, ge=0, le=10, description="the centre gate opens to this many std of the innovation while a track coasts"
    )
    centre_gate_max: float = Field(1.5, ge=0, le=20, description="... but never beyond this share of the size")
    size_gate: float = Field(
        2.0, ge=1, le=10, description="largest ratio of widths or heights of prediction and detection"
    )

    # Birth
    birth_score: float = Field(-1.5, description="least score of a detection that starts or confirms a track")
    confirm_hits: int = Field(3, ge=1, le=60, description="k: detections above birth_score that confirm a track")
    confirm_window: int = Field(8, ge=1, le=120, description="m: frames in which they must fall")
    confirm_score: float = Field(0.0, description="least mean score of those detections")
    sure_hits: int = Field(
        2, ge=1, le=60, description="number of detections that confirm a track without further ones ..."
    )
    sure_score: float | None = Field(
        1.5, description="... if their mean score is at least this (none: never fewer than confirm_hits)"
    )
    duplicate_iou: float = Field(
        0.3, ge=0, le=1, description="a detection that overlaps a track by this IoU starts no second one"
    )
    merge_iou: float = Field(0.5, ge=0, le=1, description="IoU from which two tracks count as the same sign")

    # Death
    max_coast: int = Field(
        20,
        ge=0,
        le=600,
        description="frames without detection or confident relocalisation that end a confirmed track; frames without "
        "detection that end a tentative one even if it is relocalised",
    )
    max_undetected: int = Field(
        60, ge=0, le=3600, description="frames without detection that end a confirmed track even if it is relocalised"
    )
    view_share: float = Field(0.4, ge=0, le=1, description="a track ends when a smaller share of its box is in view")
    score_decay: float = Field(
        0.9, gt=0, le=1, description="factor on a track's score margin per frame without detection"
    )

    def noise_scale(self, score: float) -> float:
        """Factor on the noise of a detection with this score, in 1..1e6.

        Signs that are far, blurred, turned or partly covered have lower scores and less exact boxes.
        """
        exponent = self.noise_score * max(0.0, self.clear_score - score)
        return math.exp(min(exponent, math.log(_MAX_NOISE_SCALE)))
