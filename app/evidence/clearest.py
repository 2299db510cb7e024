"""Finds the clearest frame of a track: the largest sharp view of its sign that the picture does not cut."""

from __future__ import annotations

import numpy as np

from app.evidence.tables import IntColumn
from tsr_engine.evidence.columns import BOX, Columns
from tsr_engine.track_table import SOURCES

__all__ = ["VIEWS", "clearest_frames"]

VIEWS = ("track_id", "frame", *BOX, "source", "score", "tracks.best_score", "frames.width", "frames.height")
"""Columns of ``track_frames`` that tell how well a sign is seen."""

_CUT = 0.05
"""A box is cut by the picture where its edge is closer to the picture's than this share of its side."""
_SHARP = 3.0
"""A view counts as sharp where its score is at least half of the track's best, or this much below it, in log-odds."""


def clearest_frames(rows: Columns, ids: IntColumn, first: IntColumn) -> IntColumn:
    """Frame of each confirmed track in which its sign is seen best.

    Of its detections those count first that lie whole in the picture, then those with a high score: blur, glare and
    what stands before a sign lower it. Of these the largest box is taken.

    Args:
        rows: ``VIEWS`` of the frames in which a confirmed track is alive.
        ids: the confirmed tracks, ascending, shape (n,).
        first: first frame of each, for those that were never detected.

    Returns:
        One frame a track, shape (n,).
    """
    frame, boxes, best = rows.ints("frame"), rows.boxes(), rows.floats("tracks.best_score")
    sides = boxes[:, 2:] - boxes[:, :2]
    picture = np.stack([rows.floats("frames.width"), rows.floats("frames.height")], axis=1)
    whole = np.all((boxes[:, :2] > _CUT * sides) & (boxes[:, 2:] < picture - _CUT * sides), axis=1)
    sharp = np.logical_not(rows.floats("score") < np.minimum(best / 2, best - _SHARP))
    detected = np.flatnonzero(rows.sources() == SOURCES.index("detected"))
    area, track = sides.prod(axis=1), rows.ints("track_id")
    order = np.lexsort((frame[detected], -area[detected], ~sharp[detected], ~whole[detected], track[detected]))
    tracks, place = np.unique(track[detected][order], return_index=True)
    found = first.copy()
    found[np.searchsorted(ids, tracks)] = frame[detected][order][place]
    return found
