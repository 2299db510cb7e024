"""What a replay changed, as the page lists it: each entry with a frame to open."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tsr_engine.pipeline import TrackSummary
    from tsr_engine.replay import ReplayReport

__all__ = ["MOST", "difference"]

MOST = 500
"""Entries a list; ``counts`` holds the full numbers."""


def difference(report: ReplayReport) -> dict[str, Any]:
    """``{counts, gained, lost, switched, relabelled}`` of a finished replay.

    * gained: ``{track, frame, last, class_id}`` of the what-if's own tracks that lie on none of the run's;
    * lost: the same of the run's tracks;
    * switched: ``{track, parts, frame}``: the run's track, the what-if's tracks on it, where the second part begins;
    * relabelled: ``{track, before, after, frame}``: the what-if's track, both classes, its last frame.
    """
    before = {track.track_id: track for track in report.before}
    now = {track.track_id: track for track in report.tracks}
    diff = report.diff
    return {
        "counts": {
            "gained": len(diff.gained),
            "lost": len(diff.lost),
            "switched": len(diff.switched),
            "relabelled": len(diff.relabelled),
        },
        "gained": [_entry(now[track]) for track in diff.gained[:MOST]],
        "lost": [_entry(before[track]) for track in diff.lost[:MOST]],
        "switched": [
            {"track": track, "parts": list(parts), "frame": sorted(now[part].first_frame for part in parts)[1]}
            for track, parts in diff.switched[:MOST]
        ],
        "relabelled": [
            {"track": track, "before": _class(old), "after": _class(new), "frame": now[track].last_frame}
            for track, old, new in diff.relabelled[:MOST]
        ],
    }


def _entry(track: TrackSummary) -> dict[str, Any]:
    return {
        "track": track.track_id,
        "frame": track.first_frame,
        "last": track.last_frame,
        "class_id": _class(track.class_id),
    }


def _class(class_id: int) -> int | None:
    return None if class_id < 0 else class_id
