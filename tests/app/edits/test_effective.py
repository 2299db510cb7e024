"""Comparisons read the same corrected boxes that a page shows, frame by frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.compare.annotation import corrected_boxes
from app.edits.documents import OPEN_END, KeyFrame, Segment, TrackDoc
from app.edits.effective import box_at
from tests.app.edits.random_commands import SPANS, engine_box, initial_documents, random_documents
from tsr_engine.track_table import TrackTable

LABELS = {1: 14, 2: 13, 3: 1}
LAST = 76


def table() -> TrackTable:
    """The toy tracks as a run's boxes."""
    rows = [(f, t - 1, box, LABELS[t]) for f in range(LAST) for t in SPANS if (box := engine_box(t, f)) is not None]
    frame, track, label = (np.array([row[i] for row in rows], np.int64) for i in (0, 1, 3))
    boxes = np.array([row[2] for row in rows], np.float64)
    return TrackTable(frame, track, boxes, label, source=frame % 3, names=tuple(f"m{track}" for track in SPANS))


@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(0, 15))
def test_corrected_boxes_equal_the_page(seed: int, length: int) -> None:
    docs = random_documents(seed, length)
    touched = {key: doc for key, doc in docs.items() if doc != initial_documents().get(key)}
    found = corrected_boxes(table(), touched, LAST)
    got = {
        (found.names[track], frame): (tuple(box), label)
        for track, frame, box, label in zip(
            found.track.tolist(), found.frame.tolist(), found.boxes.tolist(), found.class_id.tolist(), strict=True
        )
    }
    assert len(got) == len(found.frame), "a track has two boxes in a frame"
    want = {}
    for key, doc in docs.items():
        if doc.not_a_sign or doc.review == "rejected":
            continue
        pieces = [int(key[1:])] if key.startswith("m") else [s.track for s in doc.segments]
        engine = LABELS[pieces[0]] if pieces else -1
        for frame in range(LAST):
            shown = box_at(doc, frame, engine_box)
            if shown is not None:
                want[key, frame] = (shown.box, engine if shown.class_id is None else shown.class_id)
    assert got == want


@pytest.mark.parametrize("far", [LAST, LAST + 40, OPEN_END])
def test_key_frames_beyond_the_end_have_no_effect(far: int) -> None:
    keys = {5: KeyFrame(box=(0, 0, 10, 10), interpolate=True), far: KeyFrame(box=(90, 0, 100, 10))}
    piece = Segment(track=3, first=50, last=OPEN_END)
    doc = TrackDoc(key="hfar0001", segments=(piece,), keys={str(frame): key for frame, key in keys.items()})
    found = corrected_boxes(table(), {doc.key: doc}, LAST)
    of_track = found.track == found.names.index(doc.key)
    want = {frame: shown.box for frame in range(LAST) if (shown := box_at(doc, frame, engine_box)) is not None}
    assert dict(zip(found.frame[of_track].tolist(), map(tuple, found.boxes[of_track].tolist()), strict=True)) == want
    assert sorted(want) == list(range(5, LAST))
