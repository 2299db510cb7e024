"""Handles rejected tracks: tracks that people have judged not to be signs.

Retraining needs them as hard negatives. Another tool would read them as signs, whatever attribute marks them,
so a format's writer does not get them. They are written into ``manifest.json``, from which our import reads them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tsr_engine.exchange.attributes import parse_attributes
from tsr_engine.exchange.dataset import REJECTED, Dataset, Skipped, Track
from tsr_engine.exchange.filters import change_tracks
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.labels import label_name
from tsr_engine.exchange.reading import rule_error
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.labels.model import LabelSet

_FLAGS = ("key", "occluded", "ignore")


def move_rejected(dataset: Dataset, negatives: Sequence[tuple[Track, ...]]) -> Dataset:
    """The data set for writers: rejected tracks move from each video's tracks to its ``negatives``."""
    videos = (
        replace(change_tracks(video, lambda track: None if track.state == REJECTED else track), negatives=rejected)
        for video, rejected in zip(dataset.videos, negatives, strict=True)
    )
    return replace(dataset, videos=tuple(videos))


def negative_as_json(track: Track, labels: LabelSet) -> JsonObject:
    """A rejected track for the manifest: columns of plain JSON values; flags only if one is set."""
    out: JsonObject = {
        "id": track.uid,
        "class": label_name(labels, track.label),
        "source": track.source,
        "frames": track.frames.tolist(),
        "boxes": track.boxes.tolist(),
    }
    if np.isfinite(track.score).any():
        out["score"] = [score if score == score else None for score in track.score.tolist()]
    if track.labels is not None:
        out["classes"] = [label_name(labels, label) for label in track.labels.tolist()]
    for name in _FLAGS:
        values = getattr(track, name)
        if values is not None and values.any():
            out[name] = values.astype(int).tolist()
    if track.attributes:
        out["attributes"] = dict(track.attributes)
    if track.changing:
        out["changing"] = {name: values.tolist() for name, values in track.changing.items()}
    if track.notes:
        out["notes"] = [list(note) for note in track.notes]
    return out


def with_negatives(dataset: Dataset, entry: JsonMapping, target: ImportTarget, file: str) -> Dataset:
    """Add to an import the rejected tracks of the manifest beside it.

    A track of the import with the same name was added after the export, and is kept.

    Args:
        dataset: the reader's result: one video.
        entry: the manifest's entry of that video.
        target: what the reader got.
        file: the manifest's name, for messages.

    Raises:
        ImportFormatError: an entry breaks a rule.
    """
    listed = entry.get("negatives", [])
    if not isinstance(listed, list) or not listed:
        return dataset
    video = dataset.videos[0]
    if (entry.get("width"), entry.get("height")) != (video.width, video.height):
        skipped = Skipped(f"{file}: {len(listed)} rejected tracks", "Their pictures have another size.")
        return replace(dataset, skipped=(*dataset.skipped, skipped))
    imported = list(video.tracks())
    known_uids = {track.uid for track in imported}
    validator = ImportValidator(replace(target, labels=dataset.labels))
    for position, track in enumerate(listed, start=1):
        where = f"negative {position} of {video.name}"
        if not isinstance(track, dict):
            raise rule_error(file, where, "must be an object. Export it again.")
        if str(track.get("id")) not in known_uids:
            _add_track(track, validator, file, where)
    found = validator.finish(file)
    tracks = [*imported, *found.videos[0].tracks()]
    return replace(
        dataset,
        videos=(replace(video, tracks=lambda: iter(tracks)),),
        labels=found.labels,
        skipped=(*dataset.skipped, *found.skipped),
        repaired=(*dataset.repaired, *found.repaired),
    )


def _add_track(track: JsonMapping, validator: ImportValidator, file: str, where: str) -> None:
    uid, frames, boxes = track.get("id"), track.get("frames"), track.get("boxes")
    if not isinstance(uid, str) or not isinstance(frames, list) or not isinstance(boxes, list):
        raise rule_error(file, where, "must have id, frames and boxes. Export it again.")
    columns = {"boxes": boxes}
    for name in ("score", "classes", *_FLAGS):
        column = track.get(name)
        if column is not None:
            columns[name] = column
    changing = track.get("changing", {})
    if not isinstance(changing, dict):
        raise rule_error(file, where, "changing must be an object of lists. Export it again.")
    for name, column in [*columns.items(), *changing.items()]:
        if not isinstance(column, list) or len(column) != len(frames):
            raise rule_error(
                file, where, f"{name} must be a list of {len(frames)} values, one a frame. Export it again."
            )
    track_label = validator.label(str(track.get("class", "")), file, where)
    for k, (frame, box) in enumerate(zip(frames, boxes, strict=True)):
        if not isinstance(box, list) or len(box) != 4 or not all(type(edge) in (int, float) for edge in box):
            raise rule_error(file, where, f"a box must be four numbers. Got {str(box)[:60]}. Export it again.")
        score = columns["score"][k] if "score" in columns else None
        if score is not None and type(score) not in (int, float):
            raise rule_error(file, where, f"score must be a number. Got {str(score)[:40]!r}. Export it again.")
        key, occluded, ignore = (bool(columns[name][k]) if name in columns else False for name in _FLAGS)
        validator.box(
            uid,
            validator.frame(frame, file, where),
            (float(box[0]), float(box[1]), float(box[2]), float(box[3])),
            validator.label(str(columns["classes"][k]), file, where) if "classes" in columns else track_label,
            attributes=parse_attributes({name: column[k] for name, column in changing.items()}, file, where),
            file=file,
            line=where,
            key=key,
            occluded=occluded,
            ignore=ignore,
            score=math.nan if score is None else float(score),
        )
    if uid in validator:
        notes = track.get("notes", [])
        pairs = [note for note in notes if isinstance(note, list) and len(note) == 2] if isinstance(notes, list) else []
        frame_notes = [(note[0], str(note[1])) for note in pairs if type(note[0]) is int]
        validator.describe(
            uid,
            state=REJECTED,
            source=str(track.get("source", "imported")),
            notes=frame_notes,
            attributes=parse_attributes(track.get("attributes"), file, where),
        )
