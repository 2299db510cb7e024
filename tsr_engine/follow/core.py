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
from tsr_engine.follow.camera import Camera
from tsr_engine.follow.joining import join
from tsr_engine.follow.one_way import OneWay, Step
from tsr_engine.follow.outwards import Outwards
from tsr_engine.follow.placing import Placed, place, templates_of
from tsr_engine.follow.records import Anchor, Direction, Event, FollowerModels, Pictures, Proposal
from tsr_engine.geometry.boxes import clip

__all__ = ["follow"]


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
    placed = place(pictures, anchors, parts.window_scorer)
    for start in placed:
        yield Proposal(start.frame, start.shown, 1.0, "anchor")
    for left, right in pairwise(placed):
        yield from _gap(pictures, left, right, placed, parts, cancelled)
    if between:
        return
    ways = []
    if direction != "backward":
        ways.append(Outwards(pictures, placed[-1], placed, parts, "forward", last, cancelled).events())
    if direction != "forward":
        ways.append(Outwards(pictures, placed[0], placed, parts, "backward", first, cancelled).events())
    while ways:
        for way in list(ways):
            event = next(way, None)
            if event is None:
                ways.remove(way)
            else:
                yield event


def _gap(
    pictures: Pictures,
    left: Placed,
    right: Placed,
    placed: Sequence[Placed],
    parts: FollowerModels,
    cancelled: Callable[[], bool],
) -> Iterator[Proposal]:
    """The proposals of the frames between two anchors; the passes are not joined after a cancellation."""
    ahead: dict[int, Step] = {}
    back: dict[int, Step] = {}
    size = (1, 1)
    for frame, step, size in _pass(pictures, left, right, placed, parts, cancelled):
        ahead[frame] = step
        yield Proposal(frame, clip(step.box, *size), step.confidence, step.source)
    for frame, step, _ in _pass(pictures, right, left, placed, parts, cancelled):
        back[frame] = step
    if cancelled():
        return
    joined = join((left.frame, left.shown), (right.frame, right.shown), ahead, back)
    for frame in sorted(joined):
        step = joined[frame]
        yield Proposal(frame, clip(step.box, *size), step.confidence, step.source)


def _pass(
    pictures: Pictures,
    start: Placed,
    goal: Placed,
    placed: Sequence[Placed],
    parts: FollowerModels,
    cancelled: Callable[[], bool],
) -> Iterator[tuple[int, Step, tuple[int, int]]]:
    """Follow from one anchor to another, up to a cut of the film."""
    sign = 1 if goal.frame > start.frame else -1
    shown = pictures(start.frame)
    assert shown is not None, "anchors are of frames that the video has"
    camera = Camera(shown.picture)
    height, width = shown.picture.shape[:2]
    looks = templates_of(start, placed)
    way = OneWay(shown.picture, start.box, looks, "forward" if sign > 0 else "backward", parts)
    for frame in range(start.frame + sign, goal.frame, sign):
        if cancelled():
            return
        shown = pictures(frame)
        if shown is None:
            return
        turn = camera.step(shown.picture)
        step = way.step(shown.picture, turn.shift, turn.repeated, not shown.corrupt)
        if turn.cut and way.hidden:
            return
        if not np.isfinite(step.box).all():
            return
        yield frame, step.within(start.guess), (width, height)
