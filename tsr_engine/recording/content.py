"""Defines the content of a recording as plain columns."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tsr_engine.records import FloatArray
from tsr_engine.track_table import IntArray, TrackTable


@dataclass(frozen=True, slots=True)
class Frames:
    """The frames of a recording.

    Attributes:
        ordinal: shape (n,), ascending by one.
        seconds: shape (n,), presentation times.
        pts: shape (n,), presentation times in ticks of the video's time base; -1: not known.
        width: picture width, px.
        height: picture height, px.
    """

    ordinal: IntArray
    seconds: FloatArray
    pts: IntArray
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
        """Duration in s, > 0; the last frame counts as long as those before it."""
        n = len(self)
        span = float(self.seconds[-1] - self.seconds[0])
        return max(span * n / (n - 1) if n > 1 else 0.0, 1e-2 * n)

    def seconds_at(self, ordinals: IntArray) -> FloatArray:
        """Presentation times of some frames, s."""
        found: FloatArray = self.seconds[ordinals - self.first]
        return found


@dataclass(frozen=True, slots=True)
class BoxRows:
    """Boxes of one layer.

    Attributes:
        table: the boxes; their classes are the run's class numbers, or label ids for annotations, before
            ``with_classes`` converts them to the recording's numbers.
        labels: one text per box.
    """

    table: TrackTable
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        if len(self.labels) != len(self.table):
            raise ValueError(f"BoxRows must have {len(self.table)} labels. Got {len(self.labels)} instead.")

    def __len__(self) -> int:
        return len(self.table)

    def with_classes(self, class_id: IntArray) -> BoxRows:
        """The boxes with other classes, shape (n,)."""
        return replace(self, table=replace(self.table, class_id=class_id))

    def in_frames(self, frames: Frames) -> BoxRows:
        """The rows with finite boxes in the frames, ordered by frame."""
        table, first = self.table, frames.first
        keep = (table.frame >= first) & (table.frame < first + len(frames)) & np.isfinite(table.boxes).all(axis=1)
        order = np.flatnonzero(keep)
        order = order[np.argsort(table.frame[order], kind="stable")]
        return BoxRows(table.rows(order), tuple(self.labels[i] for i in order.tolist()))

    def counts(self, frames: Frames) -> IntArray:
        """Number of boxes in each frame, including zeros."""
        found: IntArray = np.bincount(self.table.frame - frames.first, minlength=len(frames)).astype(np.int64)
        return found


@dataclass(frozen=True, slots=True)
class Series:
    """Values over time, in one or more columns.

    Attributes:
        at: ordinals, shape (n,).
        values: shape (n, k), NaN: not known.
        names: names of the k columns.
    """

    at: IntArray
    values: FloatArray
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TrackSeries:
    """Values of one track over time.

    Attributes:
        track_id: the track.
        class_id: fused class; -1: unknown.
        values: by name; only those known in some frame.
        states: ordinals at which the state changes, and the new states (``detected``, ``predicted``, ``relocalised``;
            empty: the track is gone).
    """

    track_id: int
    class_id: int
    values: dict[str, Series]
    states: tuple[IntArray, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class EventLog:
    """The event log.

    Attributes:
        frame: shape (n,).
        kind: one per row.
        text: one per row.
    """

    frame: IntArray
    kind: tuple[str, ...] = ()
    text: tuple[str, ...] = ()
