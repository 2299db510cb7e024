"""Follows a sign from one box that a person has drawn, backwards and forwards through a video."""

from tsr_engine.follow.core import follow
from tsr_engine.follow.records import (
    NARROWEST,
    Anchor,
    Direction,
    Ending,
    Event,
    FollowerModels,
    Pictures,
    Proposal,
    Reason,
    Shown,
    Source,
)

__all__ = [
    "NARROWEST",
    "Anchor",
    "Direction",
    "Ending",
    "Event",
    "FollowerModels",
    "Pictures",
    "Proposal",
    "Reason",
    "Shown",
    "Source",
    "follow",
]
