"""A corrected run as tracks of a data set: documents applied to the engine's boxes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.edits.documents import TrackDoc
from app.edits.effective import AS_ENGINE, effective_track
from app.evidence.run_columns import FloatColumn, IntColumn
from app.exchange.engine_tracks import EngineTrack, EngineTracks, engine_label, unchanged
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.filters import select_frames
from tsr_engine.labels.model import AttributeValue
from tsr_engine.track_table import NO_CLASS


def run_tracks(
    folder: Path,
    documents: Mapping[str, TrackDoc],
    first: int,
    stop: int,
    frames: int,
    origin: str = "engine",
    to_label: Callable[[int], int] = unchanged,
    keys: Collection[str] | None = None,
) -> Iterator[Track]:
    """Yield the tracks of a run: the engine's by number, then those that people have made, by name.

    Deleted tracks are left out; a track that is no sign is ``rejected``.

    Args:
        folder: the evidence.
        documents: of the touched tracks, by key.
        first: first frame.
        stop: frame after the last.
        frames: length of the video; boxes beyond it are dropped.
        origin: ``source`` of untouched tracks: ``engine`` or ``imported``.
        to_label: maps a class number of the evidence to a label id, -1: none.
        keys: keys of the wanted tracks; None: all.
    """
    if keys is not None:
        documents = {key: documents[key] for key in keys if key in documents}
    drawn_keys = [key for key in sorted(documents) if not key.startswith("m")]
    with EvidenceReader(folder) as reader:
        engine_tracks = EngineTracks(reader, to_label)
        chosen = None if keys is None else [int(key[1:]) for key in keys if key.startswith("m")]
        for engine_track in engine_tracks if chosen is None else engine_tracks.chosen(chosen):
            document = documents.get(f"m{engine_track.id}")
            track: Track | None = _untouched(engine_track, origin)
            if document is not None:
                track = _edited(document, engine_tracks, engine_track, origin, frames)
            if (part := _within(track, first, stop)) is not None:
                yield part
        numbers = {f"m{number}" for number in engine_tracks.labels}
        for key in [*(k for k in sorted(documents) if k.startswith("m") and k not in numbers), *drawn_keys]:
            track = _edited(documents[key], engine_tracks, None, origin, frames)
            if (part := _within(track, first, stop)) is not None:
                yield part


def boxes_beyond(documents: Mapping[str, TrackDoc], first: int, stop: int, frames: int) -> dict[str, int]:
    """Count the boxes that people have set outside of a run's frames, by key of the track.

    Args:
        documents: of the touched tracks, by key.
        first: first frame of the run.
        stop: frame after the last.
        frames: length of the video.
    """
    counts: dict[str, int] = {}
    for key in sorted(documents):
        key_frames = documents[key].frames()
        if key_frames and (key_frames[0] < first or key_frames[-1] >= stop):
            # the engine has no boxes there, so only people's key frames give boxes
            shown = effective_track(documents[key], lambda _: (np.zeros(0, np.int64), np.zeros((0, 4))), frames).frame
            counts[key] = int(((shown < first) | (shown >= stop)).sum())
    return {key: count for key, count in counts.items() if count}


def _untouched(track: EngineTrack, origin: str) -> Track:
    none = np.zeros(len(track.frames), np.bool_)
    return Track(f"m{track.id}", track.label, track.frames, track.boxes, none, none, track.score, source=origin)


def _edited(
    document: TrackDoc, engine_tracks: EngineTracks, engine_track: EngineTrack | None, origin: str, frames: int
) -> Track | None:
    """The track that a document shows; None: nothing."""
    if document.gone:
        return None
    engine_tracks_by_id: dict[int, EngineTrack | None] = {} if engine_track is None else {engine_track.id: engine_track}

    def boxes_of(number: int) -> tuple[IntColumn, FloatColumn]:
        if number not in engine_tracks_by_id:
            engine_tracks_by_id[number] = engine_tracks.track(number)
        track = engine_tracks_by_id[number]
        return (np.zeros(0, np.int64), np.zeros((0, 4))) if track is None else (track.frames, track.boxes)

    shown = effective_track(document, boxes_of, frames)
    if not len(shown.frame):
        return None
    label = engine_label(document, engine_tracks.labels) if document.class_id is None else document.class_id
    whole = NO_CLASS if label is None else label
    labels = np.where(shown.class_id == AS_ENGINE, whole, shown.class_id)
    engine = shown.origin == 0
    score = np.full(len(shown.frame), np.nan)
    for segment in document.segments:
        piece = engine_tracks_by_id.get(segment.track)
        if piece is not None:
            index = np.minimum(np.searchsorted(piece.frames, shown.frame), max(len(piece.frames) - 1, 0))
            in_segment = engine & (segment.first <= shown.frame) & (shown.frame <= segment.last)
            in_segment &= piece.frames[index] == shown.frame if len(piece.frames) else False
            score[in_segment] = piece.score[index[in_segment]]
    is_as_engine = engine_track is not None and np.array_equal(shown.frame, engine_track.frames) and bool(engine.all())
    # An import may set only marks of hidden signs; such a key frame does not correct the box.
    keys = [
        key for key in document.keys.values() if origin != "imported" or key.box is not None or key.class_id is not None
    ]
    changed = not is_as_engine or bool(keys) or document.class_id is not None or bool(document.attributes)
    attributes, changing = _attributes(document, shown.frame)
    human = not document.segments and document.key.startswith("h")
    return Track(
        uid=document.key,
        label=whole,
        frames=shown.frame,
        boxes=shown.boxes,
        key=np.isin(shown.frame, document.frames()),
        occluded=shown.occluded,
        score=score,
        labels=labels if bool((labels != whole).any()) else None,
        state="rejected" if document.not_a_sign else document.review,
        source="human" if human else "corrected" if changed else origin,
        notes=tuple((note.frame, note.text) for note in document.notes),
        ignore=np.ones(len(shown.frame), np.bool_) if document.ignore else None,
        attributes=attributes,
        changing=changing,
    )


def _attributes(
    document: TrackDoc, frames: IntColumn
) -> tuple[dict[str, AttributeValue], dict[str, NDArray[np.object_]]]:
    """Attributes of the whole track, and those that key frames change until the next key frame."""
    keys = document.frames()
    names = {name for key in document.keys.values() for name in key.attributes}
    whole = {name: value for name, value in document.attributes.items() if name not in names}
    if not names:
        return whole, {}
    values_by_key = [document.attributes, *(document.attributes_at(key) for key in keys)]
    at = np.searchsorted(np.array(keys), frames, side="right").tolist()
    changing: dict[str, NDArray[np.object_]] = {}
    for name in sorted(names):
        values = np.full(len(frames), None, object)
        values[:] = [values_by_key[index].get(name) for index in at]
        changing[name] = values
    return whole, changing


def _within(track: Track | None, first: int, stop: int) -> Track | None:
    """The part in ``first <= frame < stop``; None: there is none."""
    if track is None or not len(track.frames):
        return None
    if first <= track.frames[0] and track.frames[-1] < stop:
        return track
    part = select_frames(track, (first <= track.frames) & (track.frames < stop))
    notes = tuple(note for note in track.notes if first <= note[0] < stop)
    return None if part is None else replace(part, notes=notes)
