"""Changes made by a replay, for the page: each entry with a frame to open."""

from __future__ import annotations

from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.classes import RunClasses
from tsr_engine.pipeline import TrackSummary
from tsr_engine.runs.replay import ReplayReport

__all__ = ["MOST", "difference"]

MOST = 500
"""Entries a list; ``counts`` holds the full numbers."""


def difference(report: ReplayReport, classes: RunClasses) -> JsonObject:
    """``{counts, gained, lost, switched, relabelled}`` of a finished replay.

    * gained: ``{track, frame, last, class_id, word}`` of the what-if's own tracks that lie on none of the run's;
    * lost: the same of the run's tracks;
    * switched: ``{track, parts, frame}``: the run's track, the what-if's tracks on it, where the second part begins;
    * relabelled: ``{track, before, after, words, frame}``: the what-if's track, both labels, its last frame.

    Labels are those of the video's set; None: never read; -1: the set lacks what the engine calls it, which ``word``
    (or ``words``, of both) then tells.

    Args:
        report: of the replay.
        classes: what the class numbers of both mean.
    """
    before = {track.track_id: track for track in report.before}
    now = {track.track_id: track for track in report.tracks}
    diff = report.diff
    relabelled = [one for one in diff.relabelled if not _same(one[1], one[2], classes)]
    return {
        "counts": {
            "gained": len(diff.gained),
            "lost": len(diff.lost),
            "switched": len(diff.switched),
            "relabelled": len(relabelled),
        },
        "gained": [_entry(now[track], classes) for track in diff.gained[:MOST]],
        "lost": [_entry(before[track], classes) for track in diff.lost[:MOST]],
        "switched": [
            {"track": track, "parts": list(parts), "frame": sorted(now[part].first_frame for part in parts)[1]}
            for track, parts in diff.switched[:MOST]
        ],
        "relabelled": [
            {
                "track": track,
                "before": _label(old, classes),
                "after": _label(new, classes),
                "words": [_word(old, classes), _word(new, classes)],
                "frame": now[track].last_frame,
            }
            for track, old, new in relabelled[:MOST]
        ],
    }


def _entry(track: TrackSummary, classes: RunClasses) -> JsonObject:
    return {
        "track": track.track_id,
        "frame": track.first_frame,
        "last": track.last_frame,
        "class_id": _label(track.class_id, classes),
        "word": _word(track.class_id, classes),
    }


def _label(class_id: int, classes: RunClasses) -> int | None:
    return None if class_id < 0 else classes.to_label(class_id)


def _word(class_id: int, classes: RunClasses) -> str | None:
    return classes.name(class_id) if classes.is_unmapped(class_id) else None


def _same(old: int, new: int, classes: RunClasses) -> bool:
    """Whether two classes are one label of the set."""
    return _label(old, classes) == _label(new, classes) and _word(old, classes) == _word(new, classes)
