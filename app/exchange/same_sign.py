"""Decides whether a track from another source is the same sign as a track of the run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tsr_engine.evaluation.matching import box_pairs
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.rows import table_of
from tsr_engine.track_table import TrackTable

__all__ = ["covered_too", "lying_on", "touching"]

_IOU = 0.5
_SHARE = 0.5
"""Frames of the shorter of two tracks in which they must lie on each other."""
_COVERED = 0.9
"""Frames of a track in which another one must lie on it, so that nothing of its own is left."""


def lying_on(tracks: Sequence[Track], shown: Mapping[str, Track]) -> dict[int, str]:
    """Place of a track -> name of the run's track that it lies on, one to one, those with most frames in common first.

    Two tracks are one sign when they have an IoU of at least 0.5 in at least half of the frames of the shorter one.
    """
    names = list(shown)
    others = [shown[name] for name in names]
    theirs, ours = table_of(tracks), table_of(others)
    if not len(theirs) or not len(ours):
        return {}
    found: dict[int, str] = {}
    taken: set[int] = set()
    for a, b, frames in _pairs(theirs, ours):
        shorter = min(len(tracks[a].frames), len(others[b].frames))
        if a not in found and b not in taken and frames >= _SHARE * shorter:
            found[a] = names[b]
            taken.add(b)
    return found


def covered_too(
    tracks: Sequence[Track], names: Sequence[str | None], shown: Mapping[str, Track]
) -> dict[int, list[str]]:
    """Place of a track -> the run's tracks that it covers besides its own, so that their signs would be there twice.

    A track is covered where it has an IoU of at least 0.5 with the other one in nine of ten of its frames. What the own
    track of the run covers by itself was there twice before, and is left as it is.

    Args:
        tracks: of the file.
        names: the run's track that each is about; None: none.
        shown: the run's tracks, by name.
    """
    used = set(names)
    others = [name for name, track in shown.items() if name not in used and track.state != "rejected"]
    theirs, ours = table_of(tracks), table_of([shown[name] for name in others])
    found: dict[int, list[str]] = {}
    if not len(theirs) or not len(ours):
        return found
    taken: set[str] = set()
    for a, b, frames in _pairs(theirs, ours):
        name, own = others[b], names[a]
        if name in taken or frames < _COVERED * len(shown[name].frames):
            continue
        if own is not None and own in shown and _covers(shown[own], shown[name]):
            continue
        found.setdefault(a, []).append(name)
        taken.add(name)
    return found


def _pairs(theirs: TrackTable, ours: TrackTable) -> Iterator[tuple[int, int, int]]:
    """Places of tracks that lie on each other, and in how many frames; those with most first."""
    pairs = box_pairs(theirs, ours, _IOU)
    both, frames = np.unique(np.column_stack([theirs.track[pairs.a], ours.track[pairs.b]]), axis=0, return_counts=True)
    for i in np.argsort(-frames, kind="stable").tolist():
        a, b = both[i].tolist()
        yield a, b, int(frames[i])


def _covers(track: Track, other: Track) -> bool:
    pairs = box_pairs(table_of([track]), table_of([other]), _IOU)
    return len(pairs.a) >= _COVERED * len(other.frames)


def touching(track: Track, other: Track) -> bool:
    """Whether two tracks of one name can be one sign: in half of their common frames, if any, their boxes touch.

    It takes little, because a person may have drawn every box anew; two signs do not even come that close.
    """
    _, a, b = np.intersect1d(track.frames, other.frames, assume_unique=True, return_indices=True)
    if not len(a):
        return False
    mine, theirs = track.boxes[a], other.boxes[b]
    apart = np.maximum(mine[:, :2], theirs[:, :2]) >= np.minimum(mine[:, 2:], theirs[:, 2:])
    return bool((~apart.any(axis=1)).mean() >= _SHARE)
