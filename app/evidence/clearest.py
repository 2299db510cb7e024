"""Where a track is best looked at: the largest sharp view of its sign that the picture does not cut."""

from __future__ import annotations

import numpy as np

from app.evidence.tables import IntColumn, columns
from tsr_engine.evidence.reader import EvidenceReader

__all__ = ["clearest_frames"]

_CUT = 0.05
"""A box is cut by the picture where its edge is closer to the picture's than this share of its side."""
_SHARP = 3.0
"""A view counts as sharp where its score is at least half of the track's best, or this much below it, in log-odds."""


def clearest_frames(reader: EvidenceReader, first: IntColumn) -> IntColumn:
    """Frame of each confirmed track in which its sign is seen best.

    Of its detections those count first that lie whole in the picture, then those with a high score: blur, glare and
    what stands before a sign lower it. Of these the largest box is taken.

    Args:
        reader: evidence of the run.
        first: first frame of each track by id, for those that were never detected.

    Returns:
        One frame a track, by id.
    """
    rows = reader.query(
        """
        SELECT t.track_id, f.frame, MAX(
            2e9 * (f.x1 > ?1 * (f.x2 - f.x1) AND f.x2 < p.width - ?1 * (f.x2 - f.x1)
                   AND f.y1 > ?1 * (f.y2 - f.y1) AND f.y2 < p.height - ?1 * (f.y2 - f.y1))
            + 1e9 * (COALESCE(f.score >= MIN(t.best_score / 2, t.best_score - ?2), 1))
            + (f.x2 - f.x1) * (f.y2 - f.y1))
        FROM tracks t
        LEFT JOIN track_frames f ON f.track_id = t.track_id AND f.source = 'detected' AND f.frame <= t.last_frame
        LEFT JOIN frames p ON p.frame = f.frame
        WHERE t.confirmed_frame IS NOT NULL GROUP BY t.track_id ORDER BY t.track_id
        """,
        (_CUT, _SHARP),
    )
    found = columns(rows, 3)[1]
    return np.where(np.isnan(found), first, found).astype(np.int64)
