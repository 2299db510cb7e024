"""Follow a sign that a person has drawn once, backwards and forwards through a video."""

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
