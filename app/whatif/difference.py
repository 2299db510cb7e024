"""Changes made by a replay, for the page: each entry with a frame to open."""

from __future__ import annotations

from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.classes import RunClasses
from tsr_engine.pipeline import TrackSummary
from tsr_engine.runs.replay import ReplayReport

MAX_ENTRIES = 500
"""Maximum number of entries in a list; ``counts`` holds the full numbers."""


def difference(report: ReplayReport, classes: RunClasses) -> JsonObject:
    """Summarise a finished replay as ``{counts, gained, lost, switched, relabelled}``.

    * gained: ``{track, frame, last, class_id, word}``: tracks of the what-if that overlap none of the run's;
    * lost: the same for tracks of the run;
    * switched: ``{track, parts, frame}``: a track of the run, the what-if's tracks on it, and the start of the second
      one;
    * relabelled: ``{track, before, after, words, frame}``: a track of the what-if, both labels, its last frame.

    Labels are those of the video's set; None: not classified; -1: the set lacks the engine's class, and ``word`` (or
    ``words``, for both) is the engine's name of it.

    Args:
        report: the report of the replay.
        classes: maps the class numbers of both to labels.
    """
    before = {track.track_id: track for track in report.before}
    after = {track.track_id: track for track in report.tracks}
    diff = report.diff
    relabelled = [change for change in diff.relabelled if not _same(change[1], change[2], classes)]
    return {
        "counts": {
            "gained": len(diff.gained),
            "lost": len(diff.lost),
            "switched": len(diff.switched),
            "relabelled": len(relabelled),
        },
        "gained": [_entry(after[track], classes) for track in diff.gained[:MAX_ENTRIES]],
        "lost": [_entry(before[track], classes) for track in diff.lost[:MAX_ENTRIES]],
        "switched": [
            {"track": track, "parts": list(parts), "frame": sorted(after[part].first_frame for part in parts)[1]}
            for track, parts in diff.switched[:MAX_ENTRIES]
        ],
        "relabelled": [
            {
                "track": track,
                "before": _label(old, classes),
                "after": _label(new, classes),
                "words": [_word(old, classes), _word(new, classes)],
                "frame": after[track].last_frame,
            }
            for track, old, new in relabelled[:MAX_ENTRIES]
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
