"""Ways to compute the boxes of a sign from drawn ones: our follower, a single-object tracker, straight lines."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from benchmarks.peers.detection_gaps import Follower
from benchmarks.peers.opencv_trackers import maker
from tsr_engine.follow import MIN_WIDTH_PX, Anchor, Ending, FollowerModels, follow
from tsr_engine.follow.outward_pass import MAX_HIDDEN_FRAMES
from tsr_engine.follow.sign_follower import visible_share
from tsr_engine.geometry.boxes import clip
from tsr_engine.json_shapes import JsonObject
from tsr_engine.records import FloatArray, Picture

PEERS = ("CSRT", "KCF", "MIL", "TLD", "KLT")
_MIN_VISIBLE_SHARE = 0.5
"""Visible share of a peer's box below which it has left the picture."""


@dataclass(frozen=True, slots=True)
class Filled:
    """The result of one way.

    Attributes:
        boxes: frame -> box, shape (4,), inside the picture.
        seconds: CPU time.
        steps: number of processed frames besides the drawn ones.
    """

    boxes: Mapping[int, FloatArray]
    seconds: float
    steps: int


@dataclass(frozen=True, slots=True)
class _Shown:
    picture: Picture
    corrupt: bool = False


def follow_with_engine(pictures: Sequence[Picture], drawn: Mapping[int, FloatArray], parts: FollowerModels) -> Filled:
    """Our follower, from one box or several."""
    asked: set[int] = set()

    def give(k: int) -> _Shown | None:
        if not 0 <= k < len(pictures):
            return None
        asked.add(k)
        return _Shown(pictures[k])

    boxes: dict[int, FloatArray] = {}
    began = time.thread_time()
    for event in follow(give, [Anchor(k, box) for k, box in drawn.items()], parts):
        if isinstance(event, Ending):
            ahead = event.direction == "forward"
            boxes = {k: b for k, b in boxes.items() if (k <= event.frame if ahead else k >= event.frame)}
        else:
            boxes[event.frame] = event.box
    return Filled(boxes, time.thread_time() - began, len(asked - set(drawn)))


def follow_with_peer(pictures: Sequence[Picture], frame: int, box: FloatArray, make: Callable[[], Follower]) -> Filled:
    """A single-object tracker, started twice on a drawn box: once for each direction.

    It ends under the same conditions as ours: half outside the picture, below the least width, or after the same number
    of frames without a result.
    """
    height, width = pictures[0].shape[:2]
    boxes = {frame: clip(box, width, height)}
    seconds, steps = 0.0, 0
    for sign in (1, -1):
        tracker = make()
        began = time.thread_time()
        tracker.start(pictures[frame], box)
        lost = 0
        k = frame + sign
        while 0 <= k < len(pictures) and lost <= MAX_HIDDEN_FRAMES:
            found = tracker.step(pictures[k])
            steps += 1
            if found is None or not np.isfinite(found).all():
                lost += 1
            else:
                lost = 0
                if visible_share(found, width, height) < _MIN_VISIBLE_SHARE or found[2] - found[0] < MIN_WIDTH_PX:
                    break
                boxes[k] = clip(found, width, height)
            k += sign
        seconds += time.thread_time() - began
    return Filled(boxes, seconds, steps)


def interpolate_linearly(drawn: Mapping[int, FloatArray]) -> dict[int, FloatArray]:
    """Straight lines between drawn boxes."""
    frames = np.array(sorted(drawn))
    edges = np.array([drawn[k] for k in frames.tolist()])
    every = np.arange(frames[0], frames[-1] + 1)
    lines = np.stack([np.interp(every, frames, edges[:, i]) for i in range(4)], axis=1)
    return dict(zip(every.tolist(), lines, strict=True))


class KltBox:
    """A box that moves and grows by the median of the Lucas-Kanade flow in it, with a forward-backward check."""

    def start(self, picture: Picture, box: FloatArray) -> None:
        """Begin with a box, shape (4,)."""
        self._grey, self._box = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.array(box, dtype=np.float64)

    def step(self, picture: Picture) -> FloatArray | None:
        """The box in the next picture; None: too few corners were matched."""
        grey, before = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), self._grey
        x1, y1, x2, y2 = self._box
        across, down = np.meshgrid(np.linspace(x1, x2, 12)[1:-1], np.linspace(y1, y2, 12)[1:-1])
        points = np.stack([across.ravel(), down.ravel()], axis=1).astype(np.float32)[:, None]
        window: JsonObject = {"winSize": (11, 11), "maxLevel": 3}
        there, found, _ = cv2.calcOpticalFlowPyrLK(before, grey, points, None, **window)
        back, again, _ = cv2.calcOpticalFlowPyrLK(grey, before, there, None, **window)
        self._grey = grey
        away = np.linalg.norm((back - points)[:, 0], axis=1)
        kept = (found[:, 0] == 1) & (again[:, 0] == 1) & (away <= max(float(np.median(away)), 1e-6)) & (away < 2.0)
        if kept.sum() < 6:
            return None
        old, new = points[kept, 0].astype(np.float64), there[kept, 0].astype(np.float64)
        moved = np.median(new - old, axis=0)
        pairs = np.triu_indices(len(old), 1)
        apart = np.linalg.norm(old[pairs[0]] - old[pairs[1]], axis=1)
        grown = float(np.median(np.linalg.norm(new[pairs[0]] - new[pairs[1]], axis=1) / np.maximum(apart, 1e-6)))
        centre, half = (self._box[:2] + self._box[2:]) / 2 + moved, (self._box[2:] - self._box[:2]) / 2 * grown
        self._box = np.concatenate([centre - half, centre + half])
        return self._box


def peer_maker(name: str) -> Callable[[], Follower]:
    """A function that makes a peer of :data:`PEERS`.

    Raises:
        Missing: this build of OpenCV does not have it.
    """
    if name == "KLT":
        return KltBox
    return maker(name)
