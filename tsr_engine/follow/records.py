"""Inputs and outputs of following."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal, Protocol

from tsr_engine.online.online_detector import OnlineDetectorMaker
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray, Picture

MIN_WIDTH_PX: Final = 10.0
"""px: following ends when the sign's box is narrower than this."""

Direction = Literal["backward", "forward"]
Source = Literal["anchor", "detected", "matched", "predicted"]
"""``anchor``: a person's box. ``detected``: the offline detector accepts the box as a sign. ``matched``: only a
template matches. ``predicted``: the sign is hidden, and the box follows its motion."""
Reason = Literal["video", "limit", "picture edge", "small", "gone", "cut", "cancelled"]
"""Why a direction ends: the video ends; the range of frames ends; the sign leaves the picture; it is narrower than
:data:`MIN_WIDTH_PX`; it is not found any more; there is a scene cut; the caller cancelled."""


class VideoFrame(Protocol):
    """One decoded frame; :class:`tsr_engine.io.video.Frame` is one."""

    @property
    def picture(self) -> Picture:
        """BGR, uint8, shape (height, width, 3)."""
        ...

    @property
    def corrupt(self) -> bool:
        """Whether the decoder concealed damage in it."""
        ...


Pictures = Callable[[int], VideoFrame | None]
"""Returns a frame by its ordinal; None: the video has no such frame."""


@dataclass(frozen=True, slots=True)
class FollowerModels:
    """The trained parts for following. Both are optional; without them, following uses only correlation.

    Attributes:
        make_online: makes the online detector that separates the sign from its surroundings.
        window_scorer: applies the offline detector's later stages to one box.
    """

    make_online: OnlineDetectorMaker | None = None
    window_scorer: Callable[[PixelSource, FloatArray], ScoredBox | None] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A box that a person has drawn.

    Attributes:
        frame: ordinal.
        box: shape (4,), px edges.
    """

    frame: int
    box: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """The box of the sign in one frame.

    A later proposal for the same frame replaces the earlier one. This happens between two anchors, where the first pass
    is reported before both are joined, and when a hidden sign is seen again, which corrects the frames before.

    Attributes:
        frame: ordinal.
        box: shape (4,), px edges, inside the picture.
        confidence: probability that the box lies on the sign, with an IoU of 0.5 or more; 1 for an anchor.
        source: source of the box.
    """

    frame: int
    box: FloatArray
    confidence: float
    source: Source


@dataclass(frozen=True, slots=True)
class Ending:
    """The end of following in one direction. Proposals beyond ``frame`` are withdrawn.

    Attributes:
        direction: direction of time.
        frame: the outermost frame that keeps a proposal.
        reason: why following ended.
        sentence: the reason as a sentence for display.
    """

    direction: Direction
    frame: int
    reason: Reason
    sentence: str


Event = Proposal | Ending
