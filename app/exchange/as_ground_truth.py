"""Tracks of a data set as ground truth: rows as in ``app.storage.ground_truth_rows.COLUMNS``."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from app.storage.ground_truth_rows import COLUMNS, Rows
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.track_numbers import track_numbers


def ground_truth_rows(tracks: Iterable[Track]) -> Rows:
    """Convert tracks to rows, ordered by frame, then by track; hidden signs have visibility 0."""
    listed = list(tracks)
    numbers = track_numbers((track.uid for track in listed), min_number=0)
    parts = [np.empty((0, len(COLUMNS)))]
    for track in listed:
        columns = {
            "frame": track.frames,
            "track_id": numbers[track.uid],
            **dict(zip(("x1", "y1", "x2", "y2"), track.boxes.T, strict=True)),
            "class_id": track.label if track.labels is None else track.labels,
            "visibility": np.where(track.occluded, 0.0, 1.0),
            "ignore": 0.0 if track.ignore is None else track.ignore,
        }
        rows = np.empty((len(track.frames), len(COLUMNS)))
        for column, name in enumerate(COLUMNS):
            rows[:, column] = columns[name]
        parts.append(rows)
    table = np.concatenate(parts)
    order = np.lexsort((table[:, COLUMNS.index("track_id")], table[:, COLUMNS.index("frame")]))
    return np.ascontiguousarray(table[order])
