"""Corrections out of a bundle: checked, and moved from the frames of the original video to those of the clip."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from app.edits.documents import KeyFrame, Note, Segment, TrackDoc
from tsr_engine.errors import ImportFormatError

__all__ = ["moved_document", "read_corrections"]

_MOST = 5000
_DOCUMENTS = TypeAdapter(list[TrackDoc])


def read_corrections(path: Path) -> list[TrackDoc]:
    """The documents of a ``corrections.json``.

    Raises:
        ImportFormatError: the first thing in it that breaks a rule.
    """
    try:
        content: Any = json.loads(path.read_text(encoding="utf-8"))
        if (
            not isinstance(content, dict)
            or content.get("format") != 1
            or not isinstance(content.get("documents"), list)
        ):
            raise ImportFormatError(f"{path.name} is not of format 1, which this version reads. Make the bundle anew.")
        documents = _DOCUMENTS.validate_json(json.dumps(content["documents"]))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))[:120]
        raise ImportFormatError(f"{path.name}, document {place}: {first['msg'][:200]}. Make the bundle anew.") from None
    except (ValueError, RecursionError):
        raise ImportFormatError(f"{path.name} is not JSON. Copy the bundle again.") from None
    if len(documents) > _MOST or len({doc.key for doc in documents}) != len(documents):
        raise ImportFormatError(f"{path.name} has a track twice, or more than {_MOST}. Make the bundle anew.")
    return documents


def moved_document(
    doc: TrackDoc, first: int, stop: int, offset: int, spans: Mapping[int, tuple[int, int]]
) -> TrackDoc | None:
    """A document as it stands in the clip; None: nothing of it is left there.

    Args:
        doc: in frames of the original video.
        first: first frame of the bundle, original.
        stop: frame after its last, original.
        offset: frame of the original video that the clip's frame 0 is.
        spans: first and last frame in the clip of the engine's tracks that are there.
    """
    pieces = []
    for piece in doc.segments:
        span = spans.get(piece.track)
        if span is None:
            continue
        low, high = max(piece.first - offset, span[0]), min(piece.last - offset, span[1])
        if low <= high:
            pieces.append(Segment(track=piece.track, first=low, last=high))
    keys = {str(frame - offset): key for frame, key in _keys_within(doc, first, stop).items()}
    own = int(doc.key[1:]) in spans if doc.key.startswith("m") else bool(pieces or keys)
    if not own:
        return None
    notes = tuple(
        Note(**{**note.model_dump(), "frame": note.frame - offset}) for note in doc.notes if first <= note.frame < stop
    )
    return doc.model_copy(
        update={"revision": 1, "segments": tuple(pieces), "keys": keys, "notes": notes, "merged_into": doc.merged_into}
    )


def _keys_within(doc: TrackDoc, first: int, stop: int) -> dict[int, KeyFrame]:
    """Key frames in the range, and what those outside of it say about its first and last frame."""
    keys = {frame: doc.keys[str(frame)] for frame in doc.frames() if first <= frame < stop}
    before = doc.last_key(first)
    if before is not None and before < first:
        state = doc.keys[str(before)]
        keys[first] = state.model_copy(update={"box": doc.line_at(first), "class_id": None})
    last = stop - 1
    if last not in keys and (line := doc.line_at(last)) is not None and doc.next_key(last) is not None:
        held = doc.keys[str(doc.last_key(last))]
        keys[last] = KeyFrame(box=line, occluded=held.occluded, interpolate=True)
    return dict(sorted(keys.items()))
