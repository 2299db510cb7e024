"""The displayed name of a track; the twin of static/js/model/track_name.js."""

from __future__ import annotations

from app.edits.documents import TrackDoc


def track_name(key: str, doc: TrackDoc | None) -> str:
    """Name an engine track by its number, and other tracks by their origin: ``#7``, ``#7 from 120``, ``drawn at 88``.

    Args:
        key: key of the track.
        doc: its document; without one, a person's track is named ``made by hand``.
    """
    if key.startswith("m"):
        return f"#{key[1:]}"
    if doc is not None and doc.segments:
        return f"#{doc.segments[0].track} from {doc.segments[0].first}"
    return f"drawn at {doc.frames()[0]}" if doc is not None and doc.keys else "made by hand"
