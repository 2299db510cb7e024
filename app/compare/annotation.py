"""The boxes of a corrected run: documents merged into the engine's tracks.

Tracks that are deleted, rejected or no sign have no boxes; unedited tracks stay as they are. The boxes of
regions to ignore count neither as a miss nor as false.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.edits.documents import TrackDoc
from app.edits.effective import AS_ENGINE, effective_track
from app.evidence.run_columns import FloatColumn, IntColumn
from tsr_engine.track_table import NO_CLASS, NO_SOURCE, TrackTable


def corrected_boxes(engine_tracks: TrackTable, documents: Mapping[str, TrackDoc], stop: int) -> TrackTable:
    """Apply documents to the engine's boxes.

    Args:
        engine_tracks: boxes of the run's confirmed tracks, named ``m...``, all before ``stop``.
        documents: documents of the touched tracks, by key.
        stop: frame after the last to include; corrections of later frames are left out.

    Returns:
        Boxes by frame; within a frame the engine's tracks by number, then those that people made, by key.
    """
    touched = np.array([key in documents for key in engine_tracks.names], np.bool_)
    keep = ~touched[engine_tracks.track] if len(engine_tracks) else np.zeros(0, np.bool_)
    engine = _Engine(engine_tracks)
    names = list(engine_tracks.names)
    index = {key: i for i, key in enumerate(names)}
    parts = [engine_tracks.rows(keep)]
    for key, document in sorted(documents.items()):
        if document.is_no_sign():
            continue
        if key not in index:
            index[key] = len(names)
            names.append(key)
        track = effective_track(document, engine.track, stop)
        labels = np.where(track.class_id == AS_ENGINE, engine.label(document), track.class_id)
        n = len(track.frame)
        part = TrackTable(
            frame=track.frame,
            track=np.full(n, index[key]),
            boxes=track.boxes,
            class_id=labels,
            source=np.where(track.origin == 0, engine.sources(document, track.frame), NO_SOURCE),
            ignore=np.full(n, document.ignore),
        )
        parts.append(part)
    return TrackTable.joined(parts, tuple(names)).ordered()


class _Engine:
    """The engine's rows by track."""

    def __init__(self, table: TrackTable) -> None:
        self._table = table
        self._place = {key: i for i, key in enumerate(table.names)}
        self._order = np.argsort(table.track, kind="stable")
        self._bounds = np.searchsorted(table.track[self._order], np.arange(len(table.names) + 1))

    def _rows(self, track: int) -> IntColumn:
        i = self._place.get(f"m{track}")
        return self._order[:0] if i is None else self._order[self._bounds[i] : self._bounds[i + 1]]

    def track(self, track: int) -> tuple[IntColumn, FloatColumn]:
        """Frames, ascending, and boxes of one track."""
        rows = self._rows(track)
        return self._table.frame[rows], self._table.boxes[rows]

    def label(self, document: TrackDoc) -> int:
        """The engine's class of a document's own track, or of its first piece; -1: none."""
        rows = (self._rows(track) for track in document.engine_tracks())
        return next((int(self._table.class_id[of_track[0]]) for of_track in rows if len(of_track)), NO_CLASS)

    def sources(self, document: TrackDoc, frames: IntColumn) -> IntColumn:
        """Source of the engine's result in each frame; -1 where no piece contains the frame."""
        known: dict[int, int] = {}
        for segment in document.segments:
            rows = self._rows(segment.track)
            frame_numbers, source = self._table.frame[rows].tolist(), self._table.source[rows].tolist()
            known.update(
                {k: s for k, s in zip(frame_numbers, source, strict=True) if segment.first <= k <= segment.last}
            )
        return np.array([known.get(k, NO_SOURCE) for k in frames.tolist()], dtype=np.int64)
