"""Follows away from the outermost anchor until there is a reason to stop."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

from tsr_engine.follow.anchors import PlacedAnchor, templates_of
from tsr_engine.follow.camera_motion import CameraMotionEstimator
from tsr_engine.follow.joined_passes import interpolate
from tsr_engine.follow.records import MIN_WIDTH_PX, Direction, Ending, Event, FollowerModels, Pictures, Proposal, Reason
from tsr_engine.follow.sign_follower import SignFollower, visible_share
from tsr_engine.geometry.boxes import MIN_SIDE, clip
from tsr_engine.records import FloatArray

MAX_HIDDEN_FRAMES: Final = 15
"""Number of frames in which the sign is not seen after which it is gone."""
MIN_VISIBLE_SHARE: Final = 0.45
"""Visible share of the box below which the sign has left the picture. The true share of a sign that was drawn at the
edge may be smaller by a seventh."""
_MAX_TRAILING: Final = 3
"""Number of frames in which the sign is not seen that still keep their proposals at the end."""


class OutwardPass:
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
        start: PlacedAnchor,
        placed: Sequence[PlacedAnchor],
        parts: FollowerModels,
        direction: Direction,
        limit: int | None,
        cancelled: Callable[[], bool],
    ) -> None:
        self._pictures, self._start, self._parts = pictures, start, parts
        self._templates = templates_of(start, placed)
        self._direction, self._limit, self._cancelled = direction, limit, cancelled
        self._sign = 1 if direction == "forward" else -1

    def events(self) -> Iterator[Event]:
        """Proposals outwards, and the ending."""
        video_frame = self._pictures(self._start.frame)
        assert video_frame is not None, "anchors are of frames that the video has"
        height, width = video_frame.picture.shape[:2]
        camera = CameraMotionEstimator(video_frame.picture)
        follower = SignFollower(video_frame.picture, self._start.box, self._templates, self._direction, self._parts)
        last_seen, last_box = self._start.frame, self._start.box
        hidden: list[Proposal] = []
        frame = last_seen
        while True:
            previous, frame = frame, frame + self._sign
            reason = self._bound(frame)
            video_frame = None if reason is not None else self._pictures(frame)
            if video_frame is None:
                yield self._end(reason or "video", previous, last_seen)
                return
            motion = camera.step(video_frame.picture)
            step = follower.step(video_frame.picture, motion.shift, motion.repeated, not video_frame.corrupt)
            has_left = visible_share(step.box, width, height) < MIN_VISIBLE_SHARE
            reason = self._stop(step.box, has_left, motion.cut and follower.hidden > 0, follower.hidden)
            if reason is not None:
                yield self._end(reason, previous, last_seen)
                return
            proposal = Proposal(frame, clip(step.box, width, height), step.confidence, step.source)
            if step.source == "predicted":
                hidden.append(proposal)
            else:
                # The sign is seen again, so the predictions of the frames in which it was hidden are corrected.
                for outdated in hidden:
                    box = interpolate((last_seen, last_box), (frame, step.box), outdated.frame)
                    yield replace(outdated, box=clip(box, width, height))
                hidden = []
                last_seen, last_box = frame, step.box
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

    def _stop(self, box: FloatArray, has_left: bool, is_cut: bool, hidden: int) -> Reason | None:
        """The reason to end before a box; None: there is none."""
        if is_cut:
            return "cut"
        if has_left:
            return "picture edge"
        if box[2] - box[0] < MIN_WIDTH_PX or box[3] - box[1] < MIN_SIDE:
            return "small"
        return "gone" if hidden > MAX_HIDDEN_FRAMES else None

    def _end(self, reason: Reason, last_frame: int, last_seen: int) -> Ending:
        """The ending after frame ``last_frame``; the sign was last seen in frame ``last_seen``.

        Predictions after that stay if the sign leaves the picture, or the video ends, within ``_MAX_TRAILING`` frames.
        """
        is_recent = abs(last_frame - last_seen) <= _MAX_TRAILING
        if reason in ("video", "limit", "small") and not is_recent:
            reason = "gone"
        frame = last_frame if is_recent and reason not in ("gone", "cut", "small") else last_seen
        is_forward = self._direction == "forward"
        preposition = "after" if is_forward else "before"
        sentences: dict[Reason, str] = {
            "video": f"The video {'ends' if is_forward else 'begins'} with frame {last_frame}.",
            "limit": f"Frame {last_frame} is the {'last' if is_forward else 'first'} of the range.",
            "picture edge": f"The sign leaves the picture {preposition} frame {frame}.",
            "small": f"The sign is narrower than {MIN_WIDTH_PX:g} px {preposition} frame {frame}.",
            "gone": f"The sign is not found {preposition} frame {frame}; the search ended at frame {last_frame}.",
            "cut": f"There is a scene cut {preposition} frame {last_frame}, and the sign is not on the other side.",
            "cancelled": f"Following was cancelled {preposition} frame {frame}.",
        }
        return Ending(self._direction, frame, reason, sentences[reason])
