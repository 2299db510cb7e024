"""The summary of a finished recording."""

from __future__ import annotations

from tsr_engine.json_shapes import JsonObject
from tsr_engine.recording import RecordingReport


def report_summary(report: RecordingReport) -> JsonObject:
    """Convert a report to plain JSON values."""
    return {
        "first": report.first,
        "stop": report.stop,
        "title": report.name,
        "picture": report.picture,
        "picture_size": report.picture_size,
        "seconds": round(report.seconds, 3),
        "boxes": report.boxes,
        "tracks": list(report.tracks),
        "events": report.events,
        "store_id": f"Recording:{report.application_id}:{report.recording_id}",
    }
