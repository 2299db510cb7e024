"""One track out of two: each frame keeps what it showed. The page does the same in static/js/model/join.js."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, takewhile

from app.edits.documents import OPEN_END, KeyFrame, Segment, TrackDoc
from tsr_engine.json_shapes import JsonObject

Span = tuple[int, int]
"""First and last frame, both included."""


def join(doc: TrackDoc, other: TrackDoc, gaps: Sequence[Segment] = ()) -> TrackDoc:
    """Add to ``doc`` the frames of ``other`` that it does not have.

    A track has the frames of its segments, of its key frames with a box, and of the lines between those. The values of
    a key frame end where the other track's frames begin: a track that left the picture does not hide the track that is
    joined to it, and no line runs across a gap. Frames of ``doc`` that are marked as outside, or lie in ``gaps``, count
    as missing where ``other`` shows something. Attributes of both tracks are combined; those of ``doc`` have
    precedence.

    Args:
        doc: the track that stays.
        other: the track that becomes part of it.
        gaps: frames in which the engine's tracks have no box.
    """
    doc, other = _with_line_ends(doc), _with_line_ends(other)
    shown, other_shown = (_shown_spans(_without_gaps(each, gaps)) for each in (doc, other))
    doc = _without(doc, _subtract(other_shown, shown))
    own_keys, other_keys = ({int(k): key for k, key in each.keys.items()} for each in (doc, other))
    keys = dict(own_keys)
    pieces = list(doc.segments)
    for first, last in _subtract(_spans(other), _spans(doc)):
        pieces += [
            Segment(track=s.track, first=max(s.first, first), last=min(s.last, last))
            for s in other.segments
            if s.first <= last and first <= s.last
        ]
        carried = _state(keys, first - 1)
        if _end_line({k: key for k, key in keys.items() if k < first}, keys):
            carried["interpolate"] = False
        after = _state(own_keys, last + 1)
        added = {k: key for k, key in other_keys.items() if first <= k <= last}
        if first not in added:
            line, start = other.line_at(first), _state(other_keys, first)
            if line is not None or start != carried:
                added[first] = KeyFrame(box=line, **start)
        edge = other.line_at(last)
        if edge is not None and last not in added:  # a cut line must end at the box that it had there
            added[last] = KeyFrame(box=edge, **_state(other_keys, last))
        _end_line(dict(added), added)
        keys = {k: key for k, key in keys.items() if not first <= k <= last} | added
        if last + 1 not in keys and last < OPEN_END and _state(keys, last + 1) != {**after, "interpolate": False}:
            keys[last + 1] = KeyFrame(**{**after, "interpolate": False})
    return doc.model_copy(
        update={
            "segments": tuple(sorted(pieces, key=lambda s: (s.first, s.track))),
            "keys": {str(k): keys[k] for k in sorted(keys)},
            "attributes": {**other.attributes, **doc.attributes},
            "notes": (*doc.notes, *(n for n in other.notes if all(n.id != note.id for note in doc.notes))),
        }
    )


def _with_line_ends(doc: TrackDoc) -> TrackDoc:
    """The same track with a box at both ends of each line, so that lines can be cut.

    Key frames before the first box start no line, because boxes of the other track may precede them.
    """
    added: dict[str, KeyFrame] = {}
    frames = doc.frames()
    for frame in takewhile(lambda k: doc.keys[str(k)].box is None, frames):
        added[str(frame)] = doc.keys[str(frame)].model_copy(update={"interpolate": False})
    for position, frame in enumerate(frames):
        key = doc.keys[str(frame)]
        start = doc.line_at(frame)
        if key.box is None and start is not None:
            added[str(frame)] = key.model_copy(update={"box": start})
        following = frames[position + 1] if position + 1 < len(frames) else None
        if following is None or following - 1 == frame or doc.line_at(following) is not None:
            continue
        end = doc.line_at(following - 1)
        if end is not None:
            added[str(following - 1)] = key.model_copy(update={"box": end, "class_id": None, "followed": False})
    return doc.model_copy(update={"keys": {**doc.keys, **added}})


def _end_line(before: dict[int, KeyFrame], keys: dict[int, KeyFrame]) -> bool:
    """Remove interpolation from the last key frame with a box of ``before`` and those after it; changes ``keys``.

    Returns:
        Whether a key frame had it.
    """
    was_line = False
    for frame in sorted(before, reverse=True):
        if before[frame].interpolate:
            keys[frame] = before[frame].model_copy(update={"interpolate": False})
            was_line = True
        if before[frame].box is not None:
            break
    return was_line


def _state(keys: dict[int, KeyFrame], frame: int) -> JsonObject:
    """The values of the last key frame at or before a frame."""
    last = max((k for k in keys if k <= frame), default=None)
    return (KeyFrame() if last is None else keys[last]).state()


def _without(doc: TrackDoc, spans: list[Span]) -> TrackDoc:
    """The track without the parts of its segments in these frames."""
    return doc.model_copy(update={"segments": tuple(part for s in doc.segments for part in _parts(s, spans))})


def _without_gaps(doc: TrackDoc, gaps: Sequence[Segment]) -> TrackDoc:
    """The track without the parts of its segments in the gaps of their engine tracks."""
    spans = {s.track: [(gap.first, gap.last) for gap in gaps if gap.track == s.track] for s in doc.segments}
    return doc.model_copy(update={"segments": tuple(part for s in doc.segments for part in _parts(s, spans[s.track]))})


def _parts(segment: Segment, spans: list[Span]) -> list[Segment]:
    """The parts of a segment outside of these frames."""
    parts = _subtract([(segment.first, segment.last)], spans)
    return [Segment(track=segment.track, first=first, last=last) for first, last in parts]


def _shown_spans(doc: TrackDoc) -> list[Span]:
    """The frames of a track that are not marked as outside."""
    frames = [*doc.frames(), OPEN_END + 1]
    outside = [(k, following - 1) for k, following in pairwise(frames) if doc.keys[str(k)].outside]
    return _subtract(_spans(doc), outside)


def _spans(doc: TrackDoc) -> list[Span]:
    """The frames of a track, as disjoint spans in order."""
    found = [(s.first, s.last) for s in doc.segments]
    frames = doc.frames()
    for position, frame in enumerate(frames):
        if doc.keys[str(frame)].box is not None and not doc.keys[str(frame)].outside:
            found.append((frame, frame))
        if position + 1 < len(frames) and doc.line_at(frames[position + 1] - 1) is not None:
            found.append((frame, frames[position + 1] - 1))
    merged: list[Span] = []
    for first, last in sorted(found):
        if merged and first <= merged[-1][1] + 1:
            merged[-1] = (merged[-1][0], max(last, merged[-1][1]))
        else:
            merged.append((first, last))
    return merged


def _subtract(spans: Sequence[Span], others: Sequence[Span]) -> list[Span]:
    """The parts of spans that no other span covers."""
    parts = list(spans)
    for low, high in others:
        parts = [
            (a, b)
            for first, last in parts
            for a, b in ((first, min(last, low - 1)), (max(first, high + 1), last))
            if a <= b
        ]
    return parts
