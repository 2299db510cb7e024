"""Finds the clearest frame of a track: the largest sharp view of its sign that the picture does not cut."""

from __future__ import annotations

import numpy as np

from app.evidence.run_columns import IntColumn
from tsr_engine.evidence.columns import BOX, Columns
from tsr_engine.track_table import SOURCES

VIEWS = ("track_id", "frame", *BOX, "source", "score", "tracks.best_score", "frames.width", "frames.height")
"""Columns of ``track_frames`` that show how clear a view of the sign is."""

_CUT_SHARE = 0.05
"""A box counts as cut off if its edge is closer to the picture's than this share of its side."""
_SHARP_LOG_ODDS = 3.0
"""A view counts as sharp if its score is at least half of the track's best, or at most this much lower, in log-odds."""


def clearest_frames(rows: Columns, ids: IntColumn, first: IntColumn) -> IntColumn:
    """Find the frame of each confirmed track in which its sign is seen best.

    Detections that lie whole in the picture are preferred, then those with a high score, because blur, glare and
    occlusion lower it. Among these the largest box wins.

    Args:
        rows: ``VIEWS`` of the frames in which a confirmed track is alive.
        ids: the confirmed tracks, ascending, shape (n,).
        first: first frame of each track, used if it was never detected.

    Returns:
        One frame per track, shape (n,).
    """
    frame, boxes, best = rows.ints("frame"), rows.boxes(), rows.floats("tracks.best_score")
    sides = boxes[:, 2:] - boxes[:, :2]
    picture = np.stack([rows.floats("frames.width"), rows.floats("frames.height")], axis=1)
    whole = np.all((boxes[:, :2] > _CUT_SHARE * sides) & (boxes[:, 2:] < picture - _CUT_SHARE * sides), axis=1)
    sharp = np.logical_not(rows.floats("score") < np.minimum(best / 2, best - _SHARP_LOG_ODDS))
    detected = np.flatnonzero(rows.sources() == SOURCES.index("detected"))
    area, track = sides.prod(axis=1), rows.ints("track_id")
    order = np.lexsort((frame[detected], -area[detected], ~sharp[detected], ~whole[detected], track[detected]))
    tracks, first_index = np.unique(track[detected][order], return_index=True)
    frames = first.copy()
    frames[np.searchsorted(ids, tracks)] = frame[detected][order][first_index]
    return frames
