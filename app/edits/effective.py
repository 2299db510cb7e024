"""What a track shows in each frame: its document over the engine's boxes. The page: static/js/model/effective.js."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.edits.documents import TrackDoc

AS_ENGINE = -2
"""Value in a column of labels: the engine's label applies. -1 is a sign of none of the classes."""

Edges = tuple[float, float, float, float]
Origin = Literal["engine", "corrected", "interpolated"]


@dataclass(frozen=True, slots=True)
class Effective:
    """A track in one frame."""

    box: Edges
    origin: Origin
    occluded: bool
    class_id: int | None
    """A person's label, -1: none of the classes; None: the engine's label applies."""


@dataclass(frozen=True, slots=True)
class EffectiveTrack:
    """A track in the frames that show it, in order.

    Attributes:
        frame: shape (n,).
        boxes: shape (n, 4), px.
        class_id: shape (n,), -1: none of the classes, ``AS_ENGINE``: the engine's label applies.
        origin: shape (n,), 0 engine, 1 corrected, 2 interpolated.
        occluded: shape (n,).
    """

    frame: NDArray[np.int64]
    boxes: NDArray[np.float64]
    class_id: NDArray[np.int64]
    origin: NDArray[np.int64]
    occluded: NDArray[np.bool_]


def box_at(doc: TrackDoc, frame: int, engine_tracks: Callable[[int, int], Edges | None]) -> Effective | None:
    """Compute what a track shows in a frame; None: nothing.

    Args:
        doc: the document.
        frame: ordinal.
        engine_tracks: (track, frame) -> the engine's box, or None.
    """
    if doc.gone:
        return None
    before = doc.last_key(frame)
    state = None if before is None else doc.keys[str(before)]
    if state is not None and state.outside:
        return None
    occluded = state is not None and state.occluded
    own = doc.keys.get(str(frame))
    label = doc.class_id if own is None or own.class_id is None else own.class_id
    line = doc.line_at(frame)
    if line is not None:
        return Effective(line, "interpolated" if own is None or own.box is None else "corrected", occluded, label)
    segment = next((s for s in doc.segments if s.first <= frame <= s.last), None)
    box = None if segment is None else engine_tracks(segment.track, frame)
    return None if box is None else Effective(box, "engine", occluded, label)


def effective_track(
    doc: TrackDoc, engine_tracks: Callable[[int], tuple[NDArray[np.int64], NDArray[np.float64]]], stop: int
) -> EffectiveTrack:
    """Compute a track in all its frames before ``stop``.

    Args:
        doc: the document; its key frames may lie anywhere.
        engine_tracks: track -> its frames, ascending, shape (n,), and boxes, shape (n, 4).
        stop: frame after the last; limits time and memory even if key frames lie further.
    """
    if doc.gone:
        return _empty_track()
    frames, boxes, has_engine_box = _engine(doc, engine_tracks, stop)
    keys = _Keys(doc)
    if len(keys.frame):
        between = np.arange(keys.frame[0], min(keys.frame[-1] + 1, stop))
        all_frames = np.union1d(frames, between)
        index = np.searchsorted(all_frames, frames)
        boxes_at = np.full((len(all_frames), 4), np.nan)
        boxes_at[index], has_engine_box = boxes, np.isin(all_frames, frames, assume_unique=True)
        frames, boxes = all_frames, boxes_at
    at = np.searchsorted(keys.frame, frames, side="right") - 1
    lines, on_key = keys.lines(frames, at)
    line = np.isfinite(lines[:, 0])
    shown = (line | has_engine_box) & ~keys.outside_at(at)
    boxes = np.where(line[:, None], lines, boxes)[shown]
    whole = AS_ENGINE if doc.class_id is None else doc.class_id
    label = keys.labels(frames, at)
    return EffectiveTrack(
        frame=frames[shown],
        boxes=np.ascontiguousarray(boxes),
        class_id=np.where(label == AS_ENGINE, whole, label)[shown],
        origin=np.where(line, np.where(on_key, 1, 2), 0)[shown],
        occluded=keys.occluded_at(at)[shown],
    )


class _Keys:
    """The key frames of a document as columns, which is fast for long tracks."""

    def __init__(self, doc: TrackDoc) -> None:
        order = doc.frames()
        keys = [doc.keys[str(frame)] for frame in order]
        n = len(order)
        self.frame = np.array(order, np.int64)
        self._box = np.array([_NO_BOX if key.box is None else key.box for key in keys], np.float64).reshape(n, 4)
        self._has = np.array([key.box is not None for key in keys], np.bool_)
        self._outside = np.array([key.outside for key in keys], np.bool_)
        self._occluded = np.array([key.occluded for key in keys], np.bool_)
        self._line = np.array([key.interpolate for key in keys], np.bool_)
        self._label = np.array([AS_ENGINE if key.class_id is None else key.class_id for key in keys], np.int64)
        indices = np.arange(n)
        self._start = np.maximum.accumulate(np.where(self._has, indices, -1)) if n else indices
        # the next key frame that has a box or is outside; n: there is none
        stops = np.where(self._has | self._outside, indices, n)
        self._end = np.append(np.minimum.accumulate(stops[::-1])[::-1][1:], n) if n else indices

    def outside_at(self, at: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the key frame ``at`` (-1: none) hides the track."""
        return self._values_at(self._outside, at)

    def occluded_at(self, at: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the key frame ``at`` marks the track as occluded."""
        return self._values_at(self._occluded, at)

    def labels(self, frames: NDArray[np.int64], at: NDArray[np.int64]) -> NDArray[np.int64]:
        """The label of a key frame in its own frame; ``AS_ENGINE`` elsewhere."""
        if not len(self.frame):
            return np.full(len(frames), AS_ENGINE)
        own = (at >= 0) & (self.frame[at] == frames)
        return np.where(own, self._label[at], AS_ENGINE)

    def lines(self, frames: NDArray[np.int64], at: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Boxes that key frames give, NaN where they give none; and whether each is a key frame's own box."""
        found = np.full((len(frames), 4), np.nan)
        on_key = np.zeros(len(frames), np.bool_)
        n = len(self.frame)
        if not n:
            return found, on_key
        on_key = (at >= 0) & (self.frame[at] == frames) & self._has[at]
        found[on_key] = self._box[at[on_key]]
        start, end = self._start[at], self._end[at]
        ends = np.minimum(end, n - 1)
        between = (at >= 0) & ~on_key & self._line[at] & (start >= 0) & (end < n) & self._has[ends]
        a, b = start[between], end[between]
        share = (frames[between] - self.frame[a]) / (self.frame[b] - self.frame[a])
        found[between] = self._box[a] + share[:, None] * (self._box[b] - self._box[a])
        return found, on_key

    def _values_at(self, values: NDArray[np.bool_], at: NDArray[np.int64]) -> NDArray[np.bool_]:
        return (at >= 0) & values[at] if len(self.frame) else np.zeros(len(at), np.bool_)


_NO_BOX = (np.nan,) * 4


def _engine(
    doc: TrackDoc, engine_tracks: Callable[[int], tuple[NDArray[np.int64], NDArray[np.float64]]], stop: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
    """Frames before ``stop``, ascending, and boxes in the segments; where segments overlap, the first one counts."""
    parts = []
    for segment in doc.segments:
        frames, table = engine_tracks(segment.track)
        rows = slice(*np.searchsorted(frames, [segment.first, min(segment.last + 1, stop)]))
        parts.append((frames[rows], table[rows]))
    if not parts:
        return np.zeros(0, np.int64), np.zeros((0, 4)), np.zeros(0, np.bool_)
    together = np.concatenate([frames for frames, _ in parts])
    distinct, first = np.unique(together, return_index=True)
    return distinct, np.concatenate([table for _, table in parts])[first], np.ones(len(distinct), np.bool_)


def _empty_track() -> EffectiveTrack:
    none = np.zeros(0, np.int64)
    return EffectiveTrack(none, np.zeros((0, 4)), none, none, np.zeros(0, np.bool_))
