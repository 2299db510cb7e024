"""Follows a sign from the boxes that a person has drawn, outwards in both directions and between them, without I/O.

::

    for event in follow(pictures, [Anchor(120, box)], parts):
        ...
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from tsr_engine.errors import UsageError
from tsr_engine.follow.anchors import PlacedAnchor, place_anchors, templates_of
from tsr_engine.follow.camera_motion import CameraMotionEstimator
from tsr_engine.follow.joined_passes import join_passes
from tsr_engine.follow.outward_pass import OutwardPass
from tsr_engine.follow.records import Anchor, Direction, Event, FollowerModels, Pictures, Proposal
from tsr_engine.follow.sign_follower import SignFollower, Step
from tsr_engine.geometry.boxes import clip


def follow(
    pictures: Pictures,
    anchors: Sequence[Anchor],
    parts: FollowerModels,
    *,
    direction: Direction | None = None,
    first: int = 0,
    last: int | None = None,
    between: bool = False,
    cancelled: Callable[[], bool] = lambda: False,
) -> Iterator[Event]:
    """Follow one sign.

    The frames between anchors come first: results of the pass from the left during that pass, then the joined results
    of both passes. The frames beyond the outermost anchors follow, outwards, alternating between both directions.

    Args:
        pictures: returns frames by ordinal; called for neighbouring frames, alternating between both directions.
        anchors: one or more boxes of the sign, in different frames.
        parts: the trained parts.
        direction: direction to follow beyond the anchors; unset: both.
        first: first frame to read.
        last: last frame to read; unset: the end of the video.
        between: whether to follow only between the outermost anchors.
        cancelled: called before each frame; true ends the iteration.

    Yields:
        Proposals, including those of the anchors' frames; and one ending as the last event of each direction.

    Raises:
        UsageError: an anchor cannot be followed or lies outside ``first`` to ``last``; raised before any proposal.
    """
    for anchor in anchors:
        if 0 <= anchor.frame < first or (last is not None and anchor.frame > last):
            end = "the end" if last is None else last
            raise UsageError(f"The box of frame {anchor.frame} is outside frames {first} to {end}. Choose another box.")
    if between and len(anchors) < 2:
        raise UsageError("Following between boxes needs at least two boxes. Add another one.")
    placed = place_anchors(pictures, anchors, parts.window_scorer)
    for start in placed:
        yield Proposal(start.frame, start.visible_box, 1.0, "anchor")
    for left, right in pairwise(placed):
        yield from _follow_between(pictures, left, right, placed, parts, cancelled)
    if between:
        return
    passes = []
    if direction != "backward":
        passes.append(OutwardPass(pictures, placed[-1], placed, parts, "forward", last, cancelled).events())
    if direction != "forward":
        passes.append(OutwardPass(pictures, placed[0], placed, parts, "backward", first, cancelled).events())
    while passes:
        for outward in list(passes):
            event = next(outward, None)
            if event is None:
                passes.remove(outward)
            else:
                yield event


def _follow_between(
    pictures: Pictures,
    left: PlacedAnchor,
    right: PlacedAnchor,
    placed: Sequence[PlacedAnchor],
    parts: FollowerModels,
    cancelled: Callable[[], bool],
) -> Iterator[Proposal]:
    """The proposals of the frames between two anchors; the passes are not joined after a cancellation."""
    forward: dict[int, Step] = {}
    backward: dict[int, Step] = {}
    size = (1, 1)
    for frame, step, size in _follow_towards(pictures, left, right, placed, parts, cancelled):
        forward[frame] = step
        yield Proposal(frame, clip(step.box, *size), step.confidence, step.source)
    for frame, step, _ in _follow_towards(pictures, right, left, placed, parts, cancelled):
        backward[frame] = step
    if cancelled():
        return
    joined = join_passes((left.frame, left.visible_box), (right.frame, right.visible_box), forward, backward)
    for frame in sorted(joined):
        step = joined[frame]
        yield Proposal(frame, clip(step.box, *size), step.confidence, step.source)


def _follow_towards(
    pictures: Pictures,
    start: PlacedAnchor,
    goal: PlacedAnchor,
    placed: Sequence[PlacedAnchor],
    parts: FollowerModels,
    cancelled: Callable[[], bool],
) -> Iterator[tuple[int, Step, tuple[int, int]]]:
    """Follow from one anchor to another, up to a cut of the film."""
    sign = 1 if goal.frame > start.frame else -1
    video_frame = pictures(start.frame)
    assert video_frame is not None, "anchors are of frames that the video has"
    camera = CameraMotionEstimator(video_frame.picture)
    height, width = video_frame.picture.shape[:2]
    templates = templates_of(start, placed)
    follower = SignFollower(video_frame.picture, start.box, templates, "forward" if sign > 0 else "backward", parts)
    for frame in range(start.frame + sign, goal.frame, sign):
        if cancelled():
            return
        video_frame = pictures(frame)
        if video_frame is None:
            return
        motion = camera.step(video_frame.picture)
        step = follower.step(video_frame.picture, motion.shift, motion.repeated, not video_frame.corrupt)
        if motion.cut and follower.hidden:
            return
        if not np.isfinite(step.box).all():
            return
        yield frame, step.within(start.extension_error), (width, height)
