"""Two tracks out of one: each frame keeps what it showed. The page does the same in static/js/model/commands.js."""

from __future__ import annotations

from app.edits.documents import KeyFrame, Segment, TrackDoc


def split(doc: TrackDoc, frame: int, new_key: str, class_id: int | None) -> tuple[TrackDoc, TrackDoc]:
    """Split a track in two: up to a frame, and from there on; either may be empty.

    Args:
        doc: document of the track.
        frame: first frame of the new track.
        new_key: key of the new track.
        class_id: the engine's label of the track, for a half that would get no label or that of another engine track.
    """
    origin = doc.original_track()
    for end, box in doc.line_ends(frame).items():
        doc = doc.with_key(end, box=box)
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
    old, new = (
        half.model_copy(update={"class_id": class_id})
        if half.class_id is None and half.original_track() != origin
        else half
        for half in (old, new)
    )
    return old, new


def clip(segments: tuple[Segment, ...], first: int, last: int) -> tuple[Segment, ...]:
    """Cut segments to the frames first to last, both included."""
    cut = ((s, max(s.first, first), min(s.last, last)) for s in segments)
    return tuple(Segment(track=s.track, first=a, last=b) for s, a, b in cut if a <= b)
