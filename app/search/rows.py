"""Rows of the search index, one for each track, made from evidence and edits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.edits.documents import TrackDoc
from tsr_engine.exchange.dataset import Track
from tsr_engine.json_shapes import JsonObject

_MAX_VALUE_LENGTH = 200
"""Maximum number of characters of an attribute's value in the tables."""
UNANSWERED = ""
"""Value of an attribute that people have set in other frames of the track only."""


@dataclass(frozen=True, slots=True)
class LastEdit:
    """The last edit of a track.

    Attributes:
        author: author of the operation.
        time: seconds since 1970 UTC.
    """

    author: str
    time: int


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of the tables as dictionaries of their columns, without those of the run."""

    tracks: list[JsonObject]
    attributes: list[JsonObject]


def make_rows(
    tracks: Iterable[Track],
    documents: Mapping[str, TrackDoc],
    edits: Mapping[str, LastEdit],
    uncertainty: Callable[[str, int], float],
    engine_label: Callable[[int], int | None],
    picture: tuple[int, int],
) -> Rows:
    """Make the rows of tracks.

    Args:
        tracks: with corrections.
        documents: documents of the touched ones, by key.
        edits: newest edit of each, by key.
        uncertainty: (key of a track, engine track that it began as) -> uncertainty before any edits.
        engine_label: maps an engine track to its label; None: not classified.
        picture: width and height, px.
    """
    rows, attributes = [], []
    for track in tracks:
        document = documents.get(track.uid)
        engine_track = int(track.uid[1:]) if document is None else document.original_track()
        engine_uncertainty = 0.0 if engine_track is None else uncertainty(track.uid, engine_track)
        edit = edits.get(track.uid)
        side = np.maximum(track.boxes[:, 2] - track.boxes[:, 0], track.boxes[:, 3] - track.boxes[:, 1])
        best = _clearest(track, side, picture)
        x1, y1, x2, y2 = track.boxes[best].tolist()
        overruled = (
            document is not None and engine_track is not None and _overruled(document, engine_track, engine_label)
        )
        rows.append(
            {
                "key": track.uid,
                "label": track.label,
                "state": track.state if track.ignore is None else "ignored",
                "uncertainty": 1.0 if overruled else engine_uncertainty,
                "engine_uncertainty": engine_uncertainty,
                "size": float(side.max()),
                "frame": int(track.frames[best]),
                "x1": x1,
                "y1": y1,
                "x2": x2,
                "y2": y2,
                "first": int(track.frames[0]),
                "last": int(track.frames[-1]),
                "revision": 0 if document is None else document.revision,
                "author": None if edit is None else edit.author,
                "edited": 0 if edit is None else edit.time,
                "notes": "\n".join(text.casefold().replace("\n", " ") for _, text in track.notes),
            }
        )
        values_set = {(name, attribute_text(value)) for name, value in track.attributes.items()}
        for name, values in track.changing.items():
            values_set |= {(name, UNANSWERED if value is None else attribute_text(value)) for value in values.tolist()}
        attributes += [{"key": track.uid, "name": name, "value": value} for name, value in sorted(values_set)]
    return Rows(rows, attributes)


def attribute_text(value: object) -> str:
    """Convert a value to the text that people write and the search compares."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return str(value).casefold()[:_MAX_VALUE_LENGTH]


def _clearest(track: Track, side: NDArray[np.float64], picture: tuple[int, int]) -> int:
    """Index of the largest box that lies whole in the picture and was measured or set by a person.

    If no box meets all conditions, one that meets some.
    """
    is_whole = (track.boxes[:, :2] >= 0).all(axis=1) & (track.boxes[:, 2:] <= picture).all(axis=1)
    is_visible = (np.isfinite(track.score) | track.key) & ~track.occluded
    for wanted in (is_whole & is_visible, is_whole, is_visible):
        if wanted.any():
            return int(np.argmax(np.where(wanted, side, -1.0)))
    return int(np.argmax(side))


def _overruled(document: TrackDoc, engine_track: int, engine_label: Callable[[int], int | None]) -> bool:
    """Whether a person gives the track another label than the engine and has not decided on it, as in the queue."""
    if document.class_id is None or document.not_a_sign or document.review in ("accepted", "rejected"):
        return False
    engine_class = engine_label(engine_track)
    return document.class_id != (-1 if engine_class is None else engine_class)
