"""Compares the boxes of our tracker and of generic ones at the end of a gap without detections.

A *gap* starts after a frame in which the detector found the sign. Our tracker runs on some frames before, as in a
drive. A generic tracker starts from the detection in that frame, as usual for such trackers.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from benchmarks.videos.engine_tracker import frame_input, start
from benchmarks.videos.stored_detections import DetectedVideo
from tsr_engine.geometry.boxes import clip, iou, non_overlap
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.params import Params
from tsr_engine.pipeline import Models, one_blas_thread
from tsr_engine.records import Detections, FloatArray, FrameEvidence, Picture

LENGTHS = (5, 10, 20)
"""Lengths of gaps, frames."""
LEAD_IN = 12
"""Number of frames before a gap that our tracker gets."""
MIN_WIDTH = 20.0
"""Least width of a sign for a gap, px."""


@dataclass(frozen=True, slots=True)
class Gap:
    """One start.

    Attributes:
        sign: id of the physical sign.
        first: last frame with detections.
        box: the detection of the sign in it, shape (4,).
        ends: length of a gap -> the sign's true box in its last frame, shape (4,).
    """

    sign: int
    first: int
    box: FloatArray
    ends: Mapping[int, FloatArray]


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of one tracker at the end of one gap.

    Attributes:
        length: length of the gap, frames.
        error: Eq. 7 in [0, 1]; 1 for a lost sign.
        iou: IoU in [0, 1]; 0 for a lost sign.
        lost: whether the tracker returned no box.
    """

    length: int
    error: float
    iou: float
    lost: bool

    @classmethod
    def of(cls, record: JsonMapping) -> Outcome:
        """An outcome from a record; other fields are ignored."""
        return cls(int(record["length"]), float(record["error"]), float(record["iou"]), bool(record["lost"]))


class Follower(Protocol):
    """A single-object tracker."""

    def start(self, picture: Picture, box: FloatArray) -> None:
        """Begin with a box, shape (4,)."""
        ...

    def step(self, picture: Picture) -> FloatArray | None:
        """The box in the next picture; None: lost."""
        ...


class StationaryBox:
    """A tracker whose box does not move, as a baseline."""

    def start(self, picture: Picture, box: FloatArray) -> None:
        """Begin with a box, shape (4,)."""
        self._box = box

    def step(self, picture: Picture) -> FloatArray | None:
        """The same box."""
        return self._box


def find_gaps(seen: DetectedVideo, every: int) -> list[Gap]:
    """Find the starts of gaps on every counted and detected sign.

    The sign must be annotated from the start of the lead-in to the end of the shortest gap at least.

    Args:
        seen: the video.
        every: least number of frames between two starts on a sign.
    """
    truth = seen.video.truth
    place = {(int(truth.track[i]), int(truth.frame[i])): i for i in np.flatnonzero(~truth.ignore)}
    gaps = []
    for sign in np.unique(truth.track[~truth.ignore]).tolist():
        last = -every
        for frame in seen.frames:
            k = frame.ordinal
            row = place.get((sign, k))
            if row is None or k - last < every or (sign, k - LEAD_IN + 1) not in place:
                continue
            box = truth.boxes[row]
            ends = {n: truth.boxes[place[sign, k + n]] for n in LENGTHS if (sign, k + n) in place}
            detection = _detection(frame.detections, box)
            if box[2] - box[0] < MIN_WIDTH or min(LENGTHS) not in ends or detection is None:
                continue
            gaps.append(Gap(sign, k, detection, ends))
            last = k
    return gaps


def follow_gap(
    make: Callable[[], Follower], pictures: Sequence[Picture], gap: Gap, box: FloatArray
) -> tuple[list[Outcome], float]:
    """Follow a gap with a generic tracker.

    Args:
        make: makes a new tracker.
        pictures: pictures of the whole video.
        gap: the gap.
        box: box at the start, shape (4,), px.

    Returns:
        One outcome for each length, and the mean CPU seconds of a step.
    """
    tracker = make()
    tracker.start(pictures[gap.first], box)
    outcomes, seconds = [], 0.0
    longest = max(gap.ends)
    for n in range(1, longest + 1):
        began = time.thread_time()
        found = tracker.step(pictures[gap.first + n])
        seconds += time.thread_time() - began
        if n in gap.ends:
            height, width = pictures[gap.first].shape[:2]
            outcomes.append(_outcome(n, found, gap.ends[n], width, height))
    return outcomes, seconds / longest


def our_outcomes(
    seen: DetectedVideo, pictures: Sequence[Picture], gap: Gap, params: Params, parts: Models
) -> tuple[list[Outcome], float]:
    """Follow a gap with our tracker, which gets ``LEAD_IN`` frames before it.

    It gets no detections in the gap; all other parts (prediction, gate, online detector, camera shift) work as usual.

    Returns:
        As :func:`follow_gap`.
    """
    core = start(seen, params, parts)
    mine: int | None = None
    outcomes, seconds = [], 0.0
    longest = max(gap.ends)
    with one_blas_thread():
        for n in range(1 - LEAD_IN, longest + 1):
            k = gap.first + n
            none = Detections.empty() if n > 0 else None
            given = frame_input(
                seen.frames[k], pictures[k], use_shift=params.tracking.use_camera_shift, detections=none
            )
            began = time.thread_time()
            out = core.step(given)
            seconds += time.thread_time() - began if n > 0 else 0.0
            if n == 0:
                mine = _track_on(out, gap.box)
            elif n in gap.ends:
                outcomes.append(_outcome(n, _box_of(out, mine), gap.ends[n], seen.width, seen.height))
    return outcomes, seconds / longest


def _track_on(frame: FrameEvidence, box: FloatArray) -> int | None:
    """The living track that lies on a box."""
    living = [t for t in frame.tracks if t.state != "dead"]
    if not living:
        return None
    overlap = iou(np.array([t.box for t in living]), box)[:, 0]
    best = int(overlap.argmax())
    return living[best].track_id if overlap[best] > 0.3 else None


def _box_of(frame: FrameEvidence, track: int | None) -> FloatArray | None:
    return next((t.box for t in frame.tracks if t.track_id == track and t.state != "dead"), None)


def _detection(detections: Detections, box: FloatArray) -> FloatArray | None:
    """The detection of a sign; None: it was not detected."""
    if not len(detections):
        return None
    overlap = iou(detections.boxes, box)[:, 0]
    best = int(overlap.argmax())
    return np.array(detections.boxes[best]) if overlap[best] >= 0.5 else None


def _outcome(length: int, found: FloatArray | None, truth: FloatArray, width: int, height: int) -> Outcome:
    """Compare the parts within the picture, since annotations and trackers differ in boxes beyond its edge."""
    if found is None or not np.isfinite(found).all():
        return Outcome(length, 1.0, 0.0, True)
    found, truth = (clip(box, width, height) for box in (found, truth))
    return Outcome(length, float(non_overlap(truth, found)[0, 0]), float(iou(truth, found)[0, 0]), False)


def summary(outcomes: Sequence[Outcome], length: int) -> JsonObject:
    """Means over the gaps of one length; ``held`` is the share with an IoU of at least 0.5."""
    here = [o for o in outcomes if o.length == length]
    if not here:
        return {"gaps": 0}
    return {
        "gaps": len(here),
        "error": float(np.mean([o.error for o in here])),
        "iou": float(np.mean([o.iou for o in here])),
        "held": float(np.mean([o.iou >= 0.5 for o in here])),
        "lost": sum(o.lost for o in here),
    }
