"""Follows away from the outermost anchor until there is a reason to stop."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

from tsr_engine.follow.camera import Camera
from tsr_engine.follow.joining import between
from tsr_engine.follow.one_way import OneWay, visible_share
from tsr_engine.follow.placing import Placed, templates_of
from tsr_engine.follow.records import NARROWEST, Direction, Ending, Event, FollowerModels, Pictures, Proposal, Reason
from tsr_engine.geometry.boxes import LEAST_SIDE, clip
from tsr_engine.records import FloatArray

__all__ = ["HIDDEN_LIMIT", "LEAST_SEEN", "Outwards"]

HIDDEN_LIMIT: Final = 15
"""Number of frames in which the sign is not seen after which it is gone."""
LEAST_SEEN: Final = 0.45
"""Visible share of the box below which the sign has left the picture. The true share of a sign that was drawn at the
edge may be smaller by a seventh."""
_LET_PASS: Final = 3
"""Number of frames in which the sign is not seen that still keep their proposals at the end."""


class Outwards:
    """Follows in one direction.

    Args:
        pictures: returns frames by ordinal.
        start: the outermost anchor.
        placed: all anchors.
        parts: the trained parts.
        direction: direction of time.
        limit: last frame to read; unset: the end of the video.
        cancelled: called before each frame; true ends the iteration.
    """

    def __init__(
        self,
        pictures: Pictures,
        start: Placed,
        placed: Sequence[Placed],
        parts: FollowerModels,
        direction: Direction,
        limit: int | None,
        cancelled: Callable[[], bool],
    ) -> None:
        self._pictures, self._start, self._parts = pictures, start, parts
        self._looks = templates_of(start, placed)
        self._direction, self._limit, self._cancelled = direction, limit, cancelled
        self._sign = 1 if direction == "forward" else -1

    def events(self) -> Iterator[Event]:
        """Proposals outwards, and the ending."""
        shown = self._pictures(self._start.frame)
        assert shown is not None, "anchors are of frames that the video has"
        height, width = shown.picture.shape[:2]
        camera = Camera(shown.picture)
        way = OneWay(shown.picture, self._start.box, self._looks, self._direction, self._parts)
        seen, box_seen = self._start.frame, self._start.box
        hidden: list[Proposal] = []
        frame = seen
        while True:
            before, frame = frame, frame + self._sign
            reason = self._bound(frame)
            shown = None if reason is not None else self._pictures(frame)
            if shown is None:
                yield self._end(reason or "video", before, seen)
                return
            turn = camera.step(shown.picture)
            step = way.step(shown.picture, turn.shift, turn.repeated, not shown.corrupt)
            left = visible_share(step.box, width, height) < LEAST_SEEN
            reason = self._stop(step.box, left, turn.cut and way.hidden > 0, way.hidden)
            if reason is not None:
                yield self._end(reason, before, seen)
                return
            proposal = Proposal(frame, clip(step.box, width, height), step.confidence, step.source)
            if step.source == "predicted":
                hidden.append(proposal)
            else:
                # The sign is seen again, so the predictions of the frames in which it was hidden are corrected.
                for late in hidden:
                    box = between((seen, box_seen), (frame, step.box), late.frame)
                    yield replace(late, box=clip(box, width, height))
                hidden = []
                seen, box_seen = frame, step.box
            yield proposal

    def _bound(self, frame: int) -> Reason | None:
        """The reason not to read a frame; None: there is none."""
        if self._cancelled():
            return "cancelled"
        if frame < 0:
            return "video"
        if self._limit is not None and (frame - self._limit) * self._sign > 0:
            return "limit"
        return None

    def _stop(self, box: FloatArray, left: bool, cut: bool, hidden: int) -> Reason | None:
        """The reason to end before a box; None: there is none."""
        if cut:
            return "cut"
        if left:
            return "picture edge"
        if box[2] - box[0] < NARROWEST or box[3] - box[1] < LEAST_SIDE:
            return "small"
        return "gone" if hidden > HIDDEN_LIMIT else None

    def _end(self, reason: Reason, before: int, seen: int) -> Ending:
        """The ending after frame ``before``; the sign was last seen in frame ``seen``.

        Predictions after that stay if the sign leaves the picture, or the video ends, within ``_LET_PASS`` frames.
        """
        few = abs(before - seen) <= _LET_PASS
        if reason in ("video", "limit", "small") and not few:
            reason = "gone"
        frame = before if few and reason not in ("gone", "cut", "small") else seen
        ahead = self._direction == "forward"
        beyond = "after" if ahead else "before"
        sentences: dict[Reason, str] = {
            "video": f"The video {'ends' if ahead else 'begins'} with frame {before}.",
            "limit": f"Frame {before} is the {'last' if ahead else 'first'} of the range.",
            "picture edge": f"The sign leaves the picture {beyond} frame {frame}.",
            "small": f"The sign is narrower than {NARROWEST:g} px {beyond} frame {frame}.",
            "gone": f"The sign is not found {beyond} frame {frame}; the search ended at frame {before}.",
            "cut": f"The film is cut {beyond} frame {before}, and the sign is not on the other side.",
            "cancelled": f"Following was cancelled {beyond} frame {frame}.",
        }
        return Ending(self._direction, frame, reason, sentences[reason])
