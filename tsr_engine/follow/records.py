"""Inputs and outputs of following."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal, Protocol

from tsr_engine.online.online_detector import OnlineDetectorMaker
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray, Picture

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
]

NARROWEST: Final = 10.0
"""px: a sign is followed until its box is narrower than this."""

Direction = Literal["backward", "forward"]
Source = Literal["anchor", "detected", "matched", "predicted"]
"""``anchor``: a person's box. ``detected``: the look of the anchors was found there, and the offline detector takes it
for a sign. ``matched``: the look was found there. ``predicted``: the sign is hidden, and its motion goes on."""
Reason = Literal["video", "limit", "picture edge", "small", "gone", "cut", "cancelled"]
"""Why a direction ends: the video ends; the frame that the caller named is reached; the sign leaves the picture; it is
narrower than :data:`NARROWEST`; nothing looks like it any more; the film is cut; the caller cancelled."""


class Shown(Protocol):
    """One decoded frame; :class:`tsr_engine.io.video.Frame` is one."""

    @property
    def picture(self) -> Picture:
        """BGR, uint8, shape (height, width, 3)."""
        ...

    @property
    def corrupt(self) -> bool:
        """Whether the decoder concealed damage in it."""
        ...


Pictures = Callable[[int], Shown | None]
"""Gives a frame by its ordinal; None: the video has no such frame."""


@dataclass(frozen=True, slots=True)
class FollowerModels:
    """The trained parts for following; without any it follows by correlation alone.

    Attributes:
        make_online: makes the online detector that tells this sign from what surrounds it.
        look: the offline detector's later stages at one place.
    """

    make_online: OnlineDetectorMaker | None = None
    look: Callable[[PixelSource, FloatArray], ScoredBox | None] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A box that a person has set.

    Attributes:
        frame: ordinal.
        box: shape (4,), px edges.
    """

    frame: int
    box: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """Where the sign is in one frame.

    A later proposal of the same frame replaces the earlier one. Between two anchors the first pass is shown while it
    runs, and both passes are joined at its end. A hidden sign that is seen again corrects the frames before.

    Attributes:
        frame: ordinal.
        box: shape (4,), px edges, inside the picture.
        confidence: probability that the box lies on the sign, with an IoU of 0.5 or more; 1 for an anchor.
        source: what the box comes from.
    """

    frame: int
    box: FloatArray
    confidence: float
    source: Source


@dataclass(frozen=True, slots=True)
class Ending:
    """How following in one direction ended. Proposals beyond ``frame`` are withdrawn.

    Attributes:
        direction: which one.
        frame: the outermost frame that keeps a proposal.
        reason: why it ended there.
        sentence: the same for people.
    """

    direction: Direction
    frame: int
    reason: Reason
    sentence: str


Event = Proposal | Ending
