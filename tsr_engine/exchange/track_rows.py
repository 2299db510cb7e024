"""Collects the rows of one track as a reader finds them, and interpolates between them."""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tsr_engine.exchange.dataset import UNSTATED_LABEL
from tsr_engine.records import FloatArray
from tsr_engine.track_table import NO_CLASS, BoolArray, IntArray

BOX = 0
"""A row with a box."""
END = 1
"""A row from whose frame on the track is hidden."""


@dataclass(slots=True)
class TrackRows:
    """The rows of one track in the file's order, in flat arrays, because there can be hundreds of thousands."""

    frame: array[int] = field(default_factory=lambda: array("q"))
    kind: array[int] = field(default_factory=lambda: array("b"))
    edges: array[float] = field(default_factory=lambda: array("d"))
    label: array[int] = field(default_factory=lambda: array("q"))
    flags: array[int] = field(default_factory=lambda: array("b"))
    score: array[float] = field(default_factory=lambda: array("d"))
    line: array[int] = field(default_factory=lambda: array("q"))
    file: array[int] = field(default_factory=lambda: array("i"))
    """Index of the row's file among those of the import; -1 in rows without a box."""
    state: str = "open"
    source: str = "imported"
    notes: list[tuple[int, str]] = field(default_factory=list)
    until: int = -1
    row_attributes: dict[int, Mapping[str, object]] = field(default_factory=dict)
    """Attributes of rows, by index of the row."""
    track_attributes: dict[str, object] = field(default_factory=dict)
    """Attributes of the whole track."""


def interpolate_rows(
    frames: IntArray,
    is_box: BoolArray,
    edges: FloatArray,
    label: IntArray,
    flags: NDArray[np.int8],
    score: FloatArray,
    until: int,
) -> tuple[IntArray, FloatArray, IntArray, NDArray[np.int8], FloatArray]:
    """Interpolate every visible frame of a track from its key rows and ends."""
    keys = np.flatnonzero(is_box)
    # Number of frames for which each key row is shown: up to the next row of either kind.
    following = np.append(frames[1:], max(int(frames[-1]), until) + 1)
    lengths = (following - frames)[keys]
    total = int(lengths.sum())
    # Index of the key row of each dense frame.
    owner = np.repeat(keys, lengths)
    starts = np.cumsum(lengths) - lengths
    step = np.arange(total) - np.repeat(starts, lengths)
    dense_frames = frames[owner] + step
    successor = np.minimum(owner + 1, len(frames) - 1)
    is_interpolated_span = is_box[successor] & (successor > owner)
    span = np.where(is_interpolated_span, frames[successor] - frames[owner], 1)
    progress = np.where(is_interpolated_span, step / span, 0.0)[:, None]
    boxes = edges[owner] + (edges[successor] - edges[owner]) * progress
    is_interpolated = step > 0
    new_flags = np.where(is_interpolated, flags[owner] & ~1, flags[owner])
    return dense_frames, boxes, label[owner], new_flags, np.where(is_interpolated, math.nan, score[owner])


def common_label(label: IntArray) -> int:
    """The most frequent label among stated ones; on a tie the smallest id, with ``NO_CLASS`` last."""
    if (label == label[0]).all():  # most tracks
        return NO_CLASS if label[0] == UNSTATED_LABEL else int(label[0])
    values, counts = np.unique(label[label != UNSTATED_LABEL], return_counts=True)
    if not len(values):
        return NO_CLASS
    most_frequent = values[counts == counts.max()]
    return int(most_frequent[most_frequent != NO_CLASS][0] if (most_frequent != NO_CLASS).any() else NO_CLASS)
