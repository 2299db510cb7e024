"""What goes into a recording, as plain columns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["BoxRows", "Frames", "Lines", "Moments", "Series"]

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Frames:
    """The frames of a recording.

    Attributes:
        ordinal: shape (n,), ascending by one.
        seconds: shape (n,), presentation times.
        pts: shape (n,), presentation times in ticks of the video's time base; -1: not known.
        width: px.
        height: px.
    """

    ordinal: Ints
    seconds: Floats
    pts: Ints
    width: int
    height: int

    def __len__(self) -> int:
        return len(self.ordinal)

    @property
    def first(self) -> int:
        """Ordinal of the first frame."""
        return int(self.ordinal[0])

    @property
    def duration(self) -> float:
        """How long they are shown, s, > 0; the last one as long as those before it."""
        n = len(self)
        span = float(self.seconds[-1] - self.seconds[0])
        return max(span * n / (n - 1) if n > 1 else 0.0, 1e-2 * n)

    def seconds_at(self, ordinals: Ints) -> Floats:
        """Presentation times of some of the frames."""
        found: Floats = self.seconds[ordinals - self.first]
        return found


@dataclass(frozen=True, slots=True)
class BoxRows:
    """Boxes of one layer.

    Attributes:
        frame: ordinal of each box, shape (n,).
        boxes: edges ``x1, y1, x2, y2``, px, shape (n, 4).
        class_id: shape (n,), -1: none; of the run, its class numbers; of what people have said, ids of the label set;
            in the recording, as that numbers labels.
        labels: one text a box.
    """

    frame: Ints
    boxes: Floats
    class_id: Ints
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        n = len(self.frame)
        shapes = (self.frame.shape, self.boxes.shape, self.class_id.shape, (len(self.labels),))
        if shapes != ((n,), (n, 4), (n,), (n,)):
            raise ValueError(f"BoxRows must have {n} frames, boxes (n, 4), classes and labels. Got {shapes} instead.")

    def __len__(self) -> int:
        return len(self.frame)

    def within(self, frames: Frames) -> BoxRows:
        """The rows with finite boxes in some frames, ordered by frame."""
        first = frames.first
        keep = (self.frame >= first) & (self.frame < first + len(frames)) & np.isfinite(self.boxes).all(axis=1)
        order = np.flatnonzero(keep)
        order = order[np.argsort(self.frame[order], kind="stable")]
        return BoxRows(
            self.frame[order],
            np.ascontiguousarray(self.boxes[order]),
            self.class_id[order],
            tuple(self.labels[i] for i in order.tolist()),
        )

    def counts(self, frames: Frames) -> Ints:
        """Number of boxes in each frame, with its zeros."""
        found: Ints = np.bincount(self.frame - frames.first, minlength=len(frames)).astype(np.int64)
        return found


@dataclass(frozen=True, slots=True)
class Series:
    """Values over time, some of them side by side.

    Attributes:
        at: ordinals, shape (n,).
        values: shape (n, k), NaN: not known there.
        names: what the columns are called, k of them.
    """

    at: Ints
    values: Floats
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Lines:
    """Values of one track over time.

    Attributes:
        track_id: the track.
        class_id: fused class; -1: unknown.
        values: by name; only those that are known in some frame.
        states: ordinals at which the state changes, and the states (``detected``, ``predicted``, ``relocalised``;
            empty: the track is not there any more).
    """

    track_id: int
    class_id: int
    values: dict[str, Series]
    states: tuple[Ints, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Moments:
    """The event log.

    Attributes:
        frame: shape (n,).
        kind: one a row.
        text: one a row.
    """

    frame: Ints
    kind: tuple[str, ...] = field(default=())
    text: tuple[str, ...] = field(default=())
