"""Reports of runs as JSON objects, for ``tsr track --json``, replays and batches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tsr_engine.json_shapes import JsonObject

if TYPE_CHECKING:
    from tsr_engine.pipeline import TrackSummary
    from tsr_engine.runs.report import RunReport, RunRequest


def report_as_json(report: RunReport, request: RunRequest) -> JsonObject:
    """A run's report as a JSON object."""
    return {
        "video": report.video,
        "width": report.width,
        "height": report.height,
        "first_frame": report.first_frame,
        "frames": report.frames,
        "resumed_at": report.resumed_at,
        "interrupted": report.interrupted,
        "focus": None
        if report.focus is None
        else {"coast_foe_y": round(report.focus.y, 3), "error": report.focus.error, "frames": report.focus.frames},
        "focus_seconds": round(report.focus_seconds, 3),
        "seconds": round(report.seconds, 3),
        "csv": None if request.csv is None else str(request.csv),
        "evidence": None if request.evidence is None else str(request.evidence),
        "annotated": None if request.annotated is None else str(request.annotated),
        "tracks": [track_as_json(track, report.class_names) for track in report.tracks],
        "events": dict(sorted(report.events.items())),
        "timing_ms": {
            stage: {"frames": count, "median": round(median, 3), "p95": round(p95, 3)}
            for stage, count, median, p95 in report.stage_table()
        },
        "warnings": list(report.warnings),
    }


def track_as_json(track: TrackSummary, names: Sequence[str]) -> JsonObject:
    """One track's summary as a JSON object; ``names`` are the display names of the classes."""
    return {
        "track_id": track.track_id,
        "class_id": track.class_id,
        "class_name": class_name(track.class_id, names),
        "share": round(track.share, 4),
        "first_frame": track.first_frame,
        "last_frame": track.last_frame,
        "frames": {source: track.frames[source] for source in ("detected", "predicted", "relocalised")},
        "best_score": round(track.best_score, 4),
        "largest_side": round(track.largest_side, 1),
    }


def class_name(class_id: int, names: Sequence[str]) -> str:
    """The class's name; ``unknown`` for -1."""
    return names[class_id] if 0 <= class_id < len(names) else "unknown"
