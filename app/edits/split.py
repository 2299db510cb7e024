"""Two tracks out of one: each frame keeps what it showed. The page does the same in static/js/model/commands.js."""

from __future__ import annotations

from app.edits.documents import OPEN_END, KeyFrame, Segment, TrackDoc


def split(doc: TrackDoc, frame: int, new_key: str, class_id: int | None) -> tuple[TrackDoc, TrackDoc]:
    """Split a track in two: up to a frame, and from there on; either may be empty.

    Args:
        doc: document of the track.
        frame: first frame of the new track.
        new_key: key of the new track.
        class_id: the engine's label of the track, for a half without any segment of the engine's.
    """
    doc = with_line_ends(doc, frame)
    carried = doc.last_key(frame)
    later = {k: key for k, key in doc.keys.items() if int(k) >= frame}
    if carried is not None and carried < frame:
        state = doc.keys[str(carried)]
        if state.occluded or state.outside or state.attributes:
            later[str(frame)] = KeyFrame(**{**state.state(), "interpolate": False})
    new = TrackDoc(
        key=new_key,
        class_id=doc.class_id,
        review="open",
        not_a_sign=doc.not_a_sign,
        attributes=doc.attributes,
        ignore=doc.ignore,
        segments=clip(doc.segments, frame, 2**31),
        keys=later,
        notes=tuple(n for n in doc.notes if n.frame >= frame),
    )
    old = doc.model_copy(
        update={
            "segments": clip(doc.segments, -1, frame - 1),
            "keys": {k: key for k, key in doc.keys.items() if int(k) < frame},
            "notes": tuple(n for n in doc.notes if n.frame < frame),
        }
    )
    return _with_class(old, class_id), _with_class(new, class_id)


def with_line_ends(doc: TrackDoc, frame: int) -> TrackDoc:
    """Add boxes where the line across a cut before a frame starts and ends, so that each half keeps its part.

    The line has gaps where key frames without a box do not interpolate.
    """
    frames = doc.frames()
    start = max((k for k in frames if k < frame and doc.has_box(k)), default=OPEN_END)
    end = min((k for k in frames if k >= frame and doc.has_box(k)), default=-1)
    changes = (k for k in frames if start < k < end and (doc.line_at(k - 1) is None) != (doc.line_at(k) is None))
    boxes = {edge: doc.line_at(edge) for k in (frame, *changes) for edge in (k - 1, k)}
    for edge, box in boxes.items():
        if box is not None and not doc.has_box(edge):
            doc = doc.with_key(edge, box=box)
    return doc


def clip(segments: tuple[Segment, ...], first: int, last: int) -> tuple[Segment, ...]:
    """Cut segments to the frames first to last, both included."""
    cut = ((s, max(s.first, first), min(s.last, last)) for s in segments)
    return tuple(Segment(track=s.track, first=a, last=b) for s, a, b in cut if a <= b)


def _with_class(doc: TrackDoc, class_id: int | None) -> TrackDoc:
    """Set the class that the document showed, if it has lost the segment with the engine's label."""
    if doc.class_id is not None or doc.original_track() is not None:
        return doc
    return doc.model_copy(update={"class_id": class_id})
