"""Joins tracks of a run that a file has as one: the run as it would be after a merge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from app.edits.documents import TrackDoc
from app.edits.join import join
from app.exchange.merge_import import labels_of
from tsr_engine.exchange.dataset import Track


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
        pieces = [piece for piece in base.segments if piece.track == number]
        is_used = np.zeros(len(other.frames), np.bool_)
        for piece in pieces:
            is_used |= (piece.first <= other.frames) & (other.frames <= piece.last)
        frames = np.concatenate([shown.frames, other.frames[is_used]])
        order = np.argsort(frames, kind="stable")
        labels = np.concatenate([labels_of(shown), np.full(int(is_used.sum()), shown.label)])[order]
        shown = replace(
            shown,
            frames=frames[order],
            boxes=np.concatenate([shown.boxes, other.boxes[is_used]])[order],
            key=np.concatenate([shown.key, other.key[is_used]])[order],
            occluded=np.concatenate([shown.occluded, other.occluded[is_used]])[order],
            score=np.concatenate([shown.score, other.score[is_used]])[order],
            labels=labels,
            changing={
                name: np.concatenate([values, np.full(int(is_used.sum()), None, object)])[order]
                for name, values in shown.changing.items()
            },
        )
    return base, shown
