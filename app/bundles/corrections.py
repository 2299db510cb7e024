"""Corrections out of a bundle: checked, and moved from the frames of the original video to those of the clip."""

from __future__ import annotations

import json
from collections.abc import Container, Iterable, Mapping
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from app.edits.documents import KeyFrame, Note, Segment, TrackDoc
from app.exchange.engine_tracks import engine_label
from tsr_engine.errors import ImportFormatError
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.classes import default_keys
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import LabelSet
from tsr_engine.track_table import NO_CLASS

_MAX_DOCUMENTS = 5000
_DOCUMENTS = TypeAdapter(list[TrackDoc])


def label_keys(documents: Iterable[JsonObject], labels: LabelSet) -> dict[str, str]:
    """Map the label ids in documents to label keys, because ids are valid only in the library that makes the bundle.

    Args:
        documents: as they are stored.
        labels: the label set of their video.
    """
    keys = {label.id: label.key for label in labels}
    return {str(number): keys[number] for number in sorted(_label_ids(documents)) if number in keys}


def with_engine_label(doc: TrackDoc, labels: Mapping[int, int], present: Container[int]) -> TrackDoc:
    """Give a document the engine's label as its own if the evidence of a clip would show another one, or none.

    Args:
        doc: the document.
        labels: label of each engine track of the run, by number; -1: not classified.
        present: numbers of the engine tracks in the clip.
    """
    label = engine_label(doc, labels)
    if doc.class_id is not None or label in (None, NO_CLASS):
        return doc
    shown = engine_label(doc, {number: each for number, each in labels.items() if number in present})
    return doc if shown == label else doc.model_copy(update={"class_id": label})


def _label_ids(documents: Iterable[JsonObject]) -> set[int]:
    labels = [part.get("class_id") for doc in documents for part in (doc, *doc.get("keys", {}).values())]
    return {label for label in labels if label is not None and label != NO_CLASS}


def relabelled_documents(
    documents: Iterable[TrackDoc], keys: Mapping[int, str], labels: LabelSet
) -> tuple[list[TrackDoc], list[str]]:
    """Convert documents of another library to the labels of this one.

    Args:
        documents: with ids of the other library.
        keys: label key of each of these ids.
        labels: the label set of the video here.

    Returns:
        The documents, and the keys that this set does not have; tracks with those labels get no label of the set.
    """
    finder, ids = LabelFinder(labels), {NO_CLASS: NO_CLASS}
    missing_keys = []
    for number, key in keys.items():
        match = finder.find(key)
        if match is None or match.how == "number":
            missing_keys.append(key)
        else:
            ids[number] = match.label.id

    def to_local(label: int | None) -> int | None:
        return None if label is None else ids.get(label, NO_CLASS)

    return [
        doc.model_copy(
            update={
                "class_id": to_local(doc.class_id),
                "keys": {f: key.model_copy(update={"class_id": to_local(key.class_id)}) for f, key in doc.keys.items()},
            }
        )
        for doc in documents
    ], missing_keys


def read_corrections(path: Path) -> tuple[list[TrackDoc], dict[int, str]]:
    """Read the documents of a ``corrections.json``, and the key of each label id in them.

    Raises:
        ImportFormatError: the file breaks a rule; the message names the first one.
    """
    try:
        content: object = json.loads(path.read_text(encoding="utf-8"))
        if (
            not isinstance(content, dict)
            or content.get("format") != 1
            or not isinstance(content.get("documents"), list)
        ):
            raise ImportFormatError(
                f"{path.name} is not of format 1, which this version reads. Create the bundle again."
            )
        documents = _DOCUMENTS.validate_json(json.dumps(content["documents"]))
    except ValidationError as error:
        first = error.errors()[0]
        location = ".".join(map(str, first["loc"]))[:120]
        raise ImportFormatError(
            f"{path.name}, document {location}: {first['msg'][:200]}. Create the bundle again."
        ) from None
    except (ValueError, RecursionError):
        raise ImportFormatError(f"{path.name} is not JSON. Copy the bundle again.") from None
    if len(documents) > _MAX_DOCUMENTS or len({doc.key for doc in documents}) != len(documents):
        raise ImportFormatError(
            f"{path.name} has a track twice, or more than {_MAX_DOCUMENTS} tracks. Create the bundle again."
        )
    for key in (key for doc in documents for key in (doc.key, doc.merged_into) if key is not None):
        if key.startswith("m") and key != f"m{int(key[1:])}":  # another name of a track, as edits refuse it
            raise ImportFormatError(
                f"{path.name}, document {key}: the number of an engine track has no zeros in front. Create the bundle "
                "again."
            )
    keys = content.get("labels", {str(number): key for number, key in enumerate(default_keys())})
    if not isinstance(keys, dict) or not all(
        key.isdecimal() and isinstance(label_key, str) for key, label_key in keys.items()
    ):
        raise ImportFormatError(f"{path.name}, labels: expected a key for each id. Create the bundle again.")
    keys_by_id = {int(number): label_key for number, label_key in keys.items()}
    unknown_ids = _label_ids(content["documents"]) - keys_by_id.keys()
    if unknown_ids:
        raise ImportFormatError(f"{path.name} has no key for label {min(unknown_ids)}. Create the bundle again.")
    return documents, {number: keys_by_id[number] for number in sorted(_label_ids(content["documents"]))}


def shift_document(
    doc: TrackDoc, first: int, stop: int, offset: int, spans: Mapping[int, tuple[int, int]]
) -> TrackDoc | None:
    """Move a document to the frames of the clip; None if nothing of it lies in the clip.

    Args:
        doc: in frames of the original video.
        first: first frame of the bundle, original.
        stop: frame after its last, original.
        offset: frame of the original video that is the clip's frame 0.
        spans: first and last frame in the clip of each engine track in it.
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
    notes = tuple(
        Note(**{**note.model_dump(), "frame": note.frame - offset}) for note in doc.notes if first <= note.frame < stop
    )
    shifted = doc.model_copy(update={"revision": 1, "segments": tuple(pieces), "keys": keys, "notes": notes})
    if doc.key.startswith("m"):
        # people can draw boxes where the engine's track has ended, or merge a track of the clip into it
        is_present = int(doc.key[1:]) in spans or not (doc.gone or shifted.empty())
    else:
        is_present = bool(pieces or keys)
    return shifted if is_present else None


def _keys_within(doc: TrackDoc, first: int, stop: int) -> dict[int, KeyFrame]:
    """Return the key frames in the range; key frames outside of it become key frames at its first and last frame."""
    keys = {frame: doc.keys[str(frame)] for frame in doc.frames() if first <= frame < stop}
    before = doc.last_key(first)
    if before is not None and before < first:
        state = doc.keys[str(before)]
        keys[first] = state.model_copy(update={"box": None, "class_id": None})
    for frame, box in (doc.line_ends(first) | doc.line_ends(stop)).items():
        if first <= frame < stop:
            key = keys.get(frame) or KeyFrame(**doc.keys[str(doc.last_key(frame))].state())
            keys[frame] = key.model_copy(update={"box": box})
    return dict(sorted(keys.items()))
