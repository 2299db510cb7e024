"""Tracks of a data set as ground truth: rows as in ``app.truths.rows.COLUMNS``."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from app.truths.rows import COLUMNS, Rows
from tsr_engine.exchange.dataset import Track

__all__ = ["track_numbers", "truth_rows"]

_NUMBERED = re.compile(r"[a-z]{0,2}0*([0-9]{1,9})", re.ASCII)


def track_numbers(uids: Iterable[str]) -> dict[str, int]:
    """A number for each name: the one in it (``7``, ``m7``, ``t007``) if no other has that, else the next free one."""
    names = list(uids)
    found: dict[str, int] = {}
    taken: set[int] = set()
    for name in names:
        match = _NUMBERED.fullmatch(name)
        if match and int(match[1]) not in taken:
            found[name] = int(match[1])
            taken.add(found[name])
    free = 1
    for name in names:
        if name not in found:
            while free in taken:
                free += 1
            found[name] = free
            taken.add(free)
    return found


def truth_rows(tracks: Iterable[Track]) -> Rows:
    """The rows of the tracks, ordered by frame, then by track; hidden signs have visibility 0."""
    listed = list(tracks)
    numbers = track_numbers(track.uid for track in listed)
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
