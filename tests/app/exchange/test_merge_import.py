"""Unchanged boxes of a file stay as in the run; changed ones become key frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.edits.documents import KeyFrame, TrackDoc, engine_doc
from app.edits.effective import AS_ENGINE, EffectiveTrack, effective_track
from app.exchange.as_annotation import THIN_PX, annotate
from app.exchange.merge_import import match, merge_import
from tests.app.edits.random_commands import SPANS, engine_box, random_documents
from tsr_engine.exchange.dataset import Track

SIZE = (500, 300)
STOP = 76
ENGINE = 14
"""The engine's class of every toy track."""


def track_arrays(track: int) -> tuple[Any, Any]:
    first, last = SPANS[track]
    rows = [(f, box) for f in range(first, last + 1) if (box := engine_box(track, f)) is not None]
    return np.array([f for f, _ in rows]), np.array([box for _, box in rows])


def as_track(document: TrackDoc) -> tuple[Track, EffectiveTrack]:
    """A document's boxes as a track of a data set."""
    found = effective_track(document, track_arrays, STOP)
    label = ENGINE if document.class_id is None else document.class_id
    labels = np.where(found.class_id == AS_ENGINE, label, found.class_id)
    n = len(found.frame)
    key = np.ones(n, np.bool_)
    track = Track(document.key, label, found.frame, found.boxes, key, found.occluded, np.full(n, np.nan), labels)
    return track, found


def somebody(seed: int, length: int) -> list[TrackDoc]:
    """Non-empty documents after some random commands."""
    return [doc for doc in random_documents(seed, length).values() if len(as_track(doc)[1].frame)]


def changed_track(track: Track, rng: np.random.Generator) -> Track:
    """The track after changes in another tool: boxes moved, removed, added, hidden, relabelled."""
    boxes, occluded = track.boxes.copy(), track.occluded.copy()
    labels = np.full(len(track.frames), track.label) if track.labels is None else track.labels.copy()
    for _ in range(rng.integers(0, 3)):
        a = rng.integers(0, len(track.frames))
        boxes[a : a + rng.integers(1, 6)] += rng.choice([-30.0, 2.0, 17.0])
    if rng.random() < 0.4:
        a = rng.integers(0, len(track.frames))
        occluded[a : a + rng.integers(1, 8)] ^= True
    if rng.random() < 0.3:
        labels[rng.integers(0, len(track.frames))] = 9
    keep = np.ones(len(track.frames), np.bool_)
    for _ in range(rng.integers(0, 3)):
        a = rng.integers(0, len(track.frames))
        keep[a : a + rng.integers(1, 6)] = False
    keep[rng.integers(0, len(keep))] = True
    new = np.setdiff1d(rng.integers(0, STOP, rng.integers(0, 4)), track.frames)
    frames = np.concatenate([track.frames[keep], new])
    order = np.argsort(frames, kind="stable")
    label = int(rng.choice([track.label, 3, -1]))
    return Track(
        track.uid,
        label,
        frames[order],
        np.concatenate([boxes[keep], np.tile([20.0, 30.0, 44.0, 52.0], (len(new), 1))])[order],
        np.ones(len(frames), np.bool_),
        np.concatenate([occluded[keep], np.zeros(len(new), np.bool_)])[order],
        np.full(len(frames), np.nan),
        labels=np.concatenate([labels[keep], np.full(len(new), label)])[order],
    )


@settings(max_examples=400, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(0, 10))
def test_the_document_shows_the_file_and_keeps_the_source_of_boxes(seed: int, length: int) -> None:
    rng = np.random.default_rng(seed)
    for doc in somebody(seed, length):
        shown, before = as_track(doc)
        track = changed_track(shown, rng)
        found = match(track, shown, doc, (10**6, 10**6), THIN_PX)
        made, _ = merge_import(track, found, doc, ENGINE, THIN_PX)
        got, after = as_track(made)
        assert got.frames.tolist() == track.frames.tolist()
        assert np.abs(got.boxes - track.boxes).max() <= THIN_PX + 0.06 + 1e-9
        assert got.occluded.tolist() == track.occluded.tolist()
        assert track.labels is not None
        assert got.labels is not None
        assert got.labels.tolist() == track.labels.tolist()
        origin = dict(zip(before.frame.tolist(), before.origin.tolist(), strict=True))
        engines = [f for f, o in zip(after.frame.tolist(), after.origin.tolist(), strict=True) if o == 0]
        same = track.frames[found.boxes].tolist()
        assert engines == [f for f in same if origin[f] == 0], (
            "what the engine found and the file repeats is the engine's"
        )


def merged_document(document: TrackDoc, **change: Any) -> TrackDoc:
    """The document after an import of the changed track."""
    shown, _ = as_track(document)
    found = annotate([replace(shown, **change)], {document.key: shown}, {document.key: document}, "ada", SIZE)
    return found.documents[document.key]


def test_only_the_class_changes() -> None:
    bare = engine_doc(1, 0, 20)
    shown, _ = as_track(bare)
    assert merged_document(bare, label=3, labels=None) == bare.model_copy(update={"class_id": 3})
    rounded = merged_document(bare, label=3, labels=None, boxes=np.round(shown.boxes + 0.03, 2))
    assert rounded == bare.model_copy(update={"class_id": 3}), "nor does what a format rounds"
    corrected = bare.model_copy(update={"keys": {"5": KeyFrame(box=(1.0, 2.0, 33.0, 44.0))}, "review": "needs_work"})
    assert merged_document(corrected, label=3, labels=None) == corrected.model_copy(update={"class_id": 3})


def test_the_class_of_the_engine_is_not_stored_as_a_correction() -> None:
    moved = as_track(engine_doc(1, 0, 20))[0].boxes.copy()
    moved[4] += 9
    assert merged_document(engine_doc(1, 0, 20), boxes=moved).class_id is None


def test_one_moved_box_is_one_key_frame() -> None:
    shown, _ = as_track(engine_doc(1, 0, 20))
    moved = shown.boxes.copy()
    moved[4] += 9
    found = merged_document(engine_doc(1, 0, 20), boxes=moved)
    assert found.frames() == [int(shown.frames[4])]
    assert found.segments == engine_doc(1, 0, 20).segments


def test_a_box_with_another_class_keeps_its_evidence() -> None:
    labels = np.full(len(as_track(engine_doc(1, 0, 20))[0].frames), ENGINE)
    labels[3] = 9
    found = merged_document(engine_doc(1, 0, 20), labels=labels)
    assert found.keys == {"3": KeyFrame(class_id=9)}


@pytest.mark.parametrize(("keep", "span"), [(slice(4, None), (4, 20)), (slice(0, 9), (0, 9))], ids=["start", "end"])
def test_frames_removed_in_the_file_are_removed(keep: slice, span: tuple[int, int]) -> None:
    shown, _ = as_track(engine_doc(1, 0, 20))
    columns = {name: getattr(shown, name)[keep] for name in ("frames", "boxes", "key", "occluded", "score", "labels")}
    found = merged_document(engine_doc(1, 0, 20), **columns)
    assert [(s.first, s.last) for s in found.segments] == [span]
    assert found.keys == {}
