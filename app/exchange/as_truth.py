"""Tracks of a data set as ground truth: rows as in ``app.storage.ground_truth_rows.COLUMNS``."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from app.storage.ground_truth_rows import COLUMNS, Rows
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.numbering import track_numbers

__all__ = ["truth_rows"]


def truth_rows(tracks: Iterable[Track]) -> Rows:
    """Convert tracks to rows, ordered by frame, then by track; hidden signs have visibility 0."""
    listed = list(tracks)
    numbers = track_numbers((track.uid for track in listed), least=0)
    parts = [np.empty((0, len(COLUMNS)))]
    for track in listed:
        n = len(track.frames)
        rows = np.empty((n, len(COLUMNS)))
        rows[:, 0], rows[:, 1], rows[:, 2:6] = track.frames, numbers[track.uid], track.boxes
        rows[:, 6] = track.label if track.labels is None else track.labels
        rows[:, 7] = np.where(track.occluded, 0.0, 1.0)
        rows[:, 8] = 0.0 if track.ignore is None else track.ignore
        parts.append(rows)
    table = np.concatenate(parts)
    return np.ascontiguousarray(table[np.lexsort((table[:, 1], table[:, 0]))])
