"""Edits carried over to another run: kept, no longer needed, conflict."""

from __future__ import annotations

import numpy as np
from pydantic import TypeAdapter

from app.edits.adopt import EngineRun, adopt_documents
from app.edits.apply import apply_command
from app.edits.commands import Command
from app.edits.documents import OPEN_END, TrackDoc, engine_doc

Spans = dict[int, tuple[int, int, float, int]]
"""Track -> first, last frame, left edge, class."""


def run(spans: Spans) -> EngineRun:
    rows = [(f, t, x + f, c) for t, (a, b, x, c) in spans.items() for f in range(a, b + 1)]
    frame, track, x, label = (np.array(column) for column in zip(*rows, strict=True))
    boxes = np.stack([x, np.full(len(x), 10.0), x + 20.0, np.full(len(x), 30.0)], 1).astype(float)
    return EngineRun(frame, track, boxes, label)


OLD: Spans = {1: (0, 30, 0, 3), 2: (0, 30, 200, 5)}
NEW: Spans = {7: (0, 32, 1, 3), 9: (0, 30, 600, 5)}
FRAMES = 100
"""Of the video."""


def edited_documents(*commands: dict[str, object]) -> dict[str, TrackDoc]:
    start = {f"m{t}": engine_doc(t, a, b) for t, (a, b, _, _) in OLD.items()}
    docs: dict[str, TrackDoc] = {}
    for raw in commands:
        docs |= apply_command({**start, **docs}, TypeAdapter(Command).validate_python({"frame": 10, **raw}))
    return docs


def test_a_label_is_kept_on_the_same_sign() -> None:
    docs = edited_documents(
        {"name": "relabel_track", "key": "m1", "class_id": 8}, {"name": "set_review", "key": "m1", "review": "accepted"}
    )
    result = adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES)
    assert (result.kept, result.not_needed, result.conflicts) == (["m7"], [], [])
    doc = result.changed["m1"]["m7"]
    assert (doc.class_id, doc.review, doc.segments[0].first, doc.segments[0].last) == (8, "accepted", 0, 32)


def test_a_verdict_is_not_adopted_by_a_different_track() -> None:
    docs = edited_documents({"name": "set_review", "key": "m1", "review": "rejected"})
    longer = run({7: (0, 90, 1, 3)})
    assert adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES).changed["m1"]["m7"].review == "rejected"
    assert adopt_documents(docs, run(OLD), longer, {}, FRAMES).changed["m1"]["m7"].review == "open"


def test_a_matching_accepted_track_stays_accepted() -> None:
    docs = edited_documents({"name": "set_review", "key": "m1", "review": "accepted"})
    accepted = engine_doc(7, 0, 32).model_copy(update={"review": "accepted"})
    result = adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES)
    assert (result.changed, result.kept, result.not_needed) == ({"m1": {"m7": accepted}}, ["m7"], [])
    moved = edited_documents(
        {"name": "set_box", "key": "m1", "box": [11.0, 10.0, 31.0, 30.0]},
        {"name": "relabel_track", "key": "m1", "class_id": 8},
        {"name": "set_review", "key": "m1", "review": "accepted"},
    )
    by_itself = adopt_documents(moved, run(OLD), run({7: (0, 32, 1, 8)}), {}, FRAMES)
    assert by_itself.changed == {"m1": {"m7": accepted}}, "corrections that the new run makes itself are not needed"
    assert adopt_documents(docs, run(OLD), run(NEW), {"m7": accepted}, FRAMES).not_needed == ["m1"]
    other = accepted.model_copy(update={"review": "rejected"})
    assert [c[0] for c in adopt_documents(docs, run(OLD), run(NEW), {"m7": other}, FRAMES).conflicts] == ["m1"]
    apart = adopt_documents(docs, run(OLD), run({7: (0, 90, 1, 3)}), {}, FRAMES)
    assert apart.changed["m1"]["m7"].review == "open"


def test_a_correction_already_in_the_new_run_is_not_needed() -> None:
    docs = edited_documents({"name": "set_box", "key": "m1", "box": [11.0, 10.0, 31.0, 30.0]})
    assert adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES).not_needed == ["m1"]
    docs = edited_documents({"name": "set_box", "key": "m1", "box": [20.0, 10.0, 40.0, 30.0]})
    assert adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES).kept == ["m7"]


def test_a_label_already_in_the_new_run_is_not_needed() -> None:
    docs = edited_documents({"name": "relabel_track", "key": "m1", "class_id": 8})
    assert adopt_documents(docs, run(OLD), run({7: (0, 30, 1, 8)}), {}, FRAMES).not_needed == ["m1"]


def test_a_missing_edited_track_is_a_conflict_unless_it_was_deleted() -> None:
    docs = edited_documents({"name": "relabel_track", "key": "m2", "class_id": 8})
    result = adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES)
    assert result.changed == {}
    assert [(key, frame) for key, _, frame in result.conflicts] == [("m2", 0)]
    docs = edited_documents({"name": "delete_track", "key": "m2"}, {"name": "delete_track", "key": "m1"})
    result = adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES)
    assert result.not_needed == ["m2"]
    assert result.changed["m1"]["m7"].gone


def test_edits_of_the_new_run_are_kept() -> None:
    docs = edited_documents({"name": "relabel_track", "key": "m1", "class_id": 8})
    reviewed = engine_doc(7, 0, 32).model_copy(update={"review": "needs_work"})
    result = adopt_documents(docs, run(OLD), run(NEW), {"m7": reviewed}, FRAMES)
    assert (result.changed, [key for key, _, _ in result.conflicts]) == ({}, ["m1"])


def test_fully_undone_tracks_have_no_edits_to_adopt() -> None:
    docs = edited_documents({"name": "relabel_track", "key": "m1", "class_id": 8})
    drawn = {"name": "create_track", "key": "hdrawn01", "box": [300.0, 9.0, 320.0, 29.0], "class_id": 2}
    docs |= apply_command({}, TypeAdapter(Command).validate_python({"frame": 10, **drawn}))
    blank = {"m7": engine_doc(7, 0, 32), "hdrawn01": TrackDoc(key="hdrawn01", gone=True)}
    result = adopt_documents(docs, run(OLD), run(NEW), blank, FRAMES)
    assert (sorted(result.kept), result.conflicts) == (["hdrawn01", "m7"], [])
    cut = {"m7": engine_doc(7, 0, 20)}
    deleted = {"m7": engine_doc(7, 0, 32).model_copy(update={"gone": True})}
    merged = {"m7": deleted["m7"].model_copy(update={"merged_into": "m9"})}
    for present in (cut, deleted, merged):
        assert [key for key, _, _ in adopt_documents(docs, run(OLD), run(NEW), present, FRAMES).conflicts] == ["m1"]


def test_a_split_stays_split_and_a_cut_stays_cut() -> None:
    docs = edited_documents(
        {"name": "split", "key": "m1", "new_key": "hlater1"}, {"name": "delete_from", "key": "hlater1", "frame": 20}
    )
    result = adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES)
    assert result.conflicts == []
    first, later = result.changed["m1"]["m7"], result.changed["hlater1"]["hlater1"]
    assert (first.segments[0].first, first.segments[0].last) == (0, 9)
    assert (later.segments[0].track, later.segments[0].first, later.segments[0].last) == (7, 10, 19)


def test_merged_pieces_stay_merged() -> None:
    old, new = run({1: (0, 10, 0, 3), 2: (20, 30, 0, 3)}), run({4: (0, 11, 0, 3), 6: (19, 30, 0, 3)})
    start = {"m1": engine_doc(1, 0, 10), "m2": engine_doc(2, 20, 30)}
    merge = TypeAdapter(Command).validate_python({"name": "merge", "key": "m1", "others": ["m2"], "frame": 0})
    result = adopt_documents(apply_command(start, merge), old, new, {}, FRAMES)
    assert [(s.track, s.first, s.last) for s in result.changed["m1"]["m4"].segments] == [(4, 0, 11), (6, 19, 30)]
    assert result.changed["m1"]["m6"].merged_into == "m4"


def test_a_sign_drawn_by_hand_is_kept_until_the_engine_finds_it() -> None:
    make = {"name": "create_track", "key": "hmade01", "frame": 0, "box": [600.0, 10.0, 620.0, 30.0], "class_id": 5}
    docs = edited_documents(make, {"name": "set_box", "key": "hmade01", "frame": 30, "box": [630.0, 10.0, 650.0, 30.0]})
    assert adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES).not_needed == ["hmade01"]
    assert adopt_documents(docs, run(OLD), run(OLD), {}, FRAMES).kept == ["hmade01"]


def test_edits_beyond_the_end_of_the_video_are_not_adopted() -> None:
    """Older versions did not check the video's length and may have stored such edits."""
    docs = edited_documents({"name": "relabel_track", "key": "m1", "class_id": 8})
    docs |= edited_documents({"name": "set_box", "key": "m2", "frame": OPEN_END, "box": [0.0, 0.0, 9.0, 9.0]})
    result = adopt_documents(docs, run(OLD), run(NEW), {}, FRAMES)
    assert result.kept == ["m7"]
    assert [(key, frame) for key, _, frame in result.conflicts] == [("m2", FRAMES - 1)]
    assert f"frame {OPEN_END}" in result.conflicts[0][1]
