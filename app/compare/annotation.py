"""A run as people have corrected it, as boxes: the documents merged into the engine's tracks.

Tracks that are deleted, rejected or no sign hold nothing; those that nobody touched stand as they are. The boxes of
regions to ignore count neither as a miss nor as false.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.edits.documents import TrackDoc
from app.edits.effective import AS_ENGINE, effective_track
from app.evidence.tables import BoxTable, FloatColumn, IntColumn

__all__ = ["corrected_boxes"]


def corrected_boxes(engine_tracks: BoxTable, documents: Mapping[str, TrackDoc], stop: int) -> BoxTable:
    """The corrected boxes.

    Args:
        engine_tracks: boxes of the run's confirmed tracks, keys ``m...``; all before ``stop``.
        documents: of the touched tracks, by key.
        stop: frame after the last that counts: what people have said of later ones is left out.

    Returns:
        Boxes by frame; in a frame the engine's tracks by number, then those that people made by key.
    """
    touched = np.array([key in documents for key in engine_tracks.keys], np.bool_)
    keep = ~touched[engine_tracks.track] if len(engine_tracks) else np.zeros(0, np.bool_)
    engine = _Engine(engine_tracks)
    keys = list(engine_tracks.keys)
    place = {key: i for i, key in enumerate(keys)}
    parts = [
        (
            engine_tracks.frame[keep],
            engine_tracks.track[keep],
            engine_tracks.boxes[keep],
            engine_tracks.class_id[keep],
            engine_tracks.source[keep],
            engine_tracks.ignore[keep],
        )
    ]
    for key, document in sorted(documents.items()):
        if document.gone or document.not_a_sign or document.review == "rejected":
            continue
        if key not in place:
            place[key] = len(keys)
            keys.append(key)
        shown = effective_track(document, engine.track, stop)
        label = np.where(shown.class_id == AS_ENGINE, engine.label(document), shown.class_id)
        source = np.where(shown.origin == 0, engine.sources(document, shown.frame), -1)
        ignore = np.full(len(shown.frame), document.ignore)
        parts.append((shown.frame, np.full(len(shown.frame), place[key]), shown.boxes, label, source, ignore))
    frame, track, boxes, labels, sources, ignored = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.lexsort((track, frame))
    return BoxTable(
        frame=frame[order],
        track=track[order],
        boxes=np.ascontiguousarray(boxes[order]),
        class_id=labels[order],
        ignore=ignored[order],
        source=sources[order],
        keys=tuple(keys),
    )


class _Engine:
    """The engine's rows by track."""

    def __init__(self, table: BoxTable) -> None:
        self._table = table
        self._place = {key: i for i, key in enumerate(table.keys)}
        self._order = np.argsort(table.track, kind="stable")
        self._bounds = np.searchsorted(table.track[self._order], np.arange(len(table.keys) + 1))

    def _rows(self, track: int) -> IntColumn:
        i = self._place.get(f"m{track}")
        return self._order[:0] if i is None else self._order[self._bounds[i] : self._bounds[i + 1]]

    def track(self, track: int) -> tuple[IntColumn, FloatColumn]:
        """Frames, ascending, and boxes of one track."""
        rows = self._rows(track)
        return self._table.frame[rows], self._table.boxes[rows]

    def label(self, document: TrackDoc) -> int:
        """The engine's class of a document's own track, else of its first piece; -1: none."""
        own = [int(document.key[1:])] if document.key.startswith("m") else []
        for track in (*own, *(segment.track for segment in document.segments)):
            rows = self._rows(track)
            if len(rows):
                return int(self._table.class_id[rows[0]])
        return -1

    def sources(self, document: TrackDoc, frames: IntColumn) -> IntColumn:
        """Where the engine's result came from in each frame; -1 where no piece holds it."""
        known: dict[int, int] = {}
        for segment in document.segments:
            rows = self._rows(segment.track)
            at, source = self._table.frame[rows].tolist(), self._table.source[rows].tolist()
            known.update({k: s for k, s in zip(at, source, strict=True) if segment.first <= k <= segment.last})
        return np.array([known.get(k, -1) for k in frames.tolist()], dtype=np.int64)
