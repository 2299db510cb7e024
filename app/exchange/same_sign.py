"""Decides whether a track from another source is the same sign as a track of the run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tsr_engine.evaluation.matching import box_pairs
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.frame_rows import table_of
from tsr_engine.track_table import TrackTable

_MIN_IOU = 0.5
_MIN_SHARE = 0.5
"""Share of the shorter track's frames in which two tracks must overlap to be one sign."""
_MIN_COVERED = 0.9
"""Share of its frames in which another track must overlap a track to cover it."""


def match_by_overlap(tracks: Sequence[Track], shown: Mapping[str, Track]) -> dict[int, str]:
    """Match tracks to the run's tracks one to one, those with most common frames first.

    Two tracks are one sign if they have an IoU of at least 0.5 in at least half of the frames of the shorter one.

    Returns:
        Index of a track -> name of the run's track.
    """
    names = list(shown)
    others = [shown[name] for name in names]
    file_table, run_table = table_of(tracks), table_of(others)
    if not len(file_table) or not len(run_table):
        return {}
    found: dict[int, str] = {}
    used: set[int] = set()
    for a, b, frames in _overlapping_pairs(file_table, run_table):
        shorter = min(len(tracks[a].frames), len(others[b].frames))
        if a not in found and b not in used and frames >= _MIN_SHARE * shorter:
            found[a] = names[b]
            used.add(b)
    return found


def also_covered(
    tracks: Sequence[Track], names: Sequence[str | None], shown: Mapping[str, Track]
) -> dict[int, list[str]]:
    """Find the run's tracks that a track covers besides its own, because their signs would be there twice.

    A track is covered if it has an IoU of at least 0.5 with the other one in nine of ten of its frames. What the own
    track of the run already covers was there twice before, and is left as it is.

    Args:
        tracks: tracks of the file.
        names: the run's track of each; None: none.
        shown: the run's tracks, by name.

    Returns:
        Index of a track -> names of the run's tracks.
    """
    used = set(names)
    others = [name for name, track in shown.items() if name not in used and track.state != "rejected"]
    file_table, run_table = table_of(tracks), table_of([shown[name] for name in others])
    found: dict[int, list[str]] = {}
    if not len(file_table) or not len(run_table):
        return found
    used_names: set[str] = set()
    for a, b, frames in _overlapping_pairs(file_table, run_table):
        name, own = others[b], names[a]
        if name in used_names or frames < _MIN_COVERED * len(shown[name].frames):
            continue
        if own is not None and own in shown and _covers(shown[own], shown[name]):
            continue
        found.setdefault(a, []).append(name)
        used_names.add(name)
    return found


def _overlapping_pairs(file_table: TrackTable, run_table: TrackTable) -> Iterator[tuple[int, int, int]]:
    """Indices of overlapping tracks and their number of common frames, highest first."""
    pairs = box_pairs(file_table, run_table, _MIN_IOU)
    both, frames = np.unique(
        np.column_stack([file_table.track[pairs.a], run_table.track[pairs.b]]), axis=0, return_counts=True
    )
    for i in np.argsort(-frames, kind="stable").tolist():
        a, b = both[i].tolist()
        yield a, b, int(frames[i])


def _covers(track: Track, other: Track) -> bool:
    pairs = box_pairs(table_of([track]), table_of([other]), _MIN_IOU)
    return len(pairs.a) >= _MIN_COVERED * len(other.frames)


def boxes_touch(track: Track, other: Track) -> bool:
    """Whether two tracks of one name can be one sign: their boxes touch in half of their common frames, if any.

    The condition is weak because a person may have drawn every box again; different signs do not meet even this one.
    """
    _, a, b = np.intersect1d(track.frames, other.frames, assume_unique=True, return_indices=True)
    if not len(a):
        return False
    boxes, other_boxes = track.boxes[a], other.boxes[b]
    is_apart = np.maximum(boxes[:, :2], other_boxes[:, :2]) >= np.minimum(boxes[:, 2:], other_boxes[:, 2:])
    return bool((~is_apart.any(axis=1)).mean() >= _MIN_SHARE)
