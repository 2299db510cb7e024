"""Joins tracks of a run that a file has as one: the run as it would be after a merge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from app.edits.documents import TrackDoc
from app.edits.join import join
from app.exchange.merge_import import labels_of
from tsr_engine.exchange.dataset import Track
from tsr_engine.json_shapes import JsonObject


def join_tracks(base: TrackDoc, shown: Track, others: Iterable[tuple[TrackDoc, Track]]) -> tuple[TrackDoc, Track]:
    """Add the frames of other tracks to a track, so that their boxes still come from the engine.

    Args:
        base: the document of the track.
        shown: the track as displayed.
        others: documents of untouched engine tracks, and the tracks as displayed.

    Returns:
        The document, and the track as displayed.
    """
    for document, other in others:
        base = join(base, document)
        (number,) = {piece.track for piece in document.segments}
        is_used = np.zeros(len(other.frames), np.bool_)
        for piece in base.segments:
            if piece.track == number:
                is_used |= (piece.first <= other.frames) & (other.frames <= piece.last)
        count = int(is_used.sum())
        order = np.argsort(np.concatenate([shown.frames, other.frames[is_used]]), kind="stable")
        columns: JsonObject = {
            name: np.concatenate([getattr(shown, name), getattr(other, name)[is_used]])[order]
            for name in ("frames", "boxes", "key", "occluded", "score")
        }
        changing = {
            name: np.concatenate([values, np.full(count, None, object)])[order]
            for name, values in shown.changing.items()
        }
        labels = np.concatenate([labels_of(shown), np.full(count, shown.label)])[order]
        shown = replace(shown, **columns, labels=labels, changing=changing)
    return base, shown
