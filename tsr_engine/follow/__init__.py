"""Follows a sign from one box that a person has drawn, backwards and forwards through a video."""

from tsr_engine.follow.core import follow
from tsr_engine.follow.records import (
    MIN_WIDTH_PX,
    Anchor,
    Direction,
    Ending,
    Event,
    FollowerModels,
    Pictures,
    Proposal,
    Reason,
    Source,
    VideoFrame,
)

__all__ = [
    "MIN_WIDTH_PX",
    "Anchor",
    "Direction",
    "Ending",
    "Event",
    "FollowerModels",
    "Pictures",
    "Proposal",
    "Reason",
    "Source",
    "VideoFrame",
    "follow",
]
