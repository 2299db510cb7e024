"""Tracks of a file as documents: they show the file's boxes with few key frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.edits.documents import NO_CLASS, TrackDoc, engine_doc
from app.edits.effective import effective_track
from app.exchange.as_annotation import annotate
from app.exchange.as_ground_truth import ground_truth_rows
from app.exchange.engine_tracks import EngineTrackInfo
from tests.app.exchange.exchange_client import assert_same_track
from tsr_engine.exchange.dataset import Track
from tsr_engine.exchange.track_numbers import track_numbers

SIZE = (320, 240)


def line(uid: str = "t1", frames: range | list[int] = range(10), label: int = 14, **more: object) -> Track:
    """A sign that grows evenly."""
    at = np.array(list(frames), np.int64)
    boxes = np.column_stack([50 - at, 60 - at, 70 + at * 1.5, 80 + at * 1.25]).astype(np.float64)
    none = np.zeros(len(at), np.bool_)
    track = Track(uid, label, at, boxes, ~none, none, np.full(len(at), np.nan))
    return replace(track, **more)  # type: ignore[arg-type]


def shown_track(document: TrackDoc, engine: Track | None = None) -> Track:
    """Boxes that a document shows over a track of the engine."""
    nothing = np.zeros(0, np.int64), np.zeros((0, 4))
    boxes = nothing if engine is None else (engine.frames, engine.boxes)
    found = effective_track(document, lambda _: boxes, 1000)
    n = len(found.frame)
    return Track(
        document.key,
        -1 if document.class_id is None else document.class_id,
        found.frame,
        found.boxes,
        np.zeros(n, np.bool_),
        found.occluded,
        np.full(n, np.nan),
        labels=np.where(found.class_id < 0, -1, found.class_id),
    )


def only_document(tracks: list[Track]) -> TrackDoc:
    """The single resulting document."""
    found = annotate(tracks, {}, {}, "ada", SIZE)
    assert (found.made, found.changed, found.same) == (1, 0, 0)
    return next(iter(found.documents.values()))


def test_a_dense_track_is_thinned_and_shows_the_same_boxes() -> None:
    track = line(frames=range(40))
    document = only_document([track])
    assert len(document.keys) == 2, "a straight line needs its ends only"
    assert_same_track(shown_track(document), track, 0.5)
    noisy = replace(track, boxes=track.boxes + np.random.default_rng(1).normal(0, 0.1, track.boxes.shape))
    document = only_document([noisy])
    assert 2 <= len(document.keys) < 20
    assert_same_track(shown_track(document), noisy, 0.5 + 1e-9)


def test_key_frames_of_the_file_stay_key_frames() -> None:
    key = np.zeros(10, np.bool_)
    key[[0, 4, 9]] = True
    assert only_document([line(key=key)]).frames() == [0, 4, 9]


def test_gaps_stay_gaps() -> None:
    track = line(frames=[3, 4, 5, 9, 10, 11, 20])
    assert_same_track(shown_track(only_document([track])), track, 0.5)


def test_hidden_frames_and_labels_by_frame_stay() -> None:
    hidden = np.zeros(10, np.bool_)
    hidden[4:7] = True
    labels = np.full(10, 14)
    labels[[2, 3, 8]] = 9
    track = line(occluded=hidden, labels=labels)
    assert_same_track(shown_track(only_document([track])), track, 0.5)


def test_state_and_notes_are_imported() -> None:
    document = only_document([line(state="accepted", notes=((3, "bent"), (4, "")))])
    assert document.review == "accepted"
    assert [(note.frame, note.text, note.author) for note in document.notes] == [(3, "bent", "ada")]
    assert only_document([line(label=-1, silent=np.ones(10, np.bool_))]).class_id is None
    assert only_document([line(state="truth", label=-1)]).class_id == NO_CLASS


def test_ignored_regions_are_left_out_and_reported() -> None:
    ignore = np.zeros(10, np.bool_)
    ignore[3:] = True
    found = annotate([line(ignore=ignore), line("t2", ignore=~np.zeros(10, np.bool_))], {}, {}, "ada", SIZE)
    first, second = found.documents.values()
    assert (shown_track(first).frames.tolist(), first.ignore) == ([0, 1, 2], False)
    assert (shown_track(second).frames.tolist(), second.ignore) == (list(range(10)), True), "all of it is such a region"
    assert found.skipped[0].what == "7 boxes that are to be ignored"


def test_an_equal_track_is_unchanged() -> None:
    track = line("m7")
    rounded = replace(track, boxes=np.round(track.boxes + 0.004, 2))
    there = {"m7": engine_doc(7, 0, 9)}
    assert annotate([rounded], {"m7": track}, there, "ada", SIZE).same == 1
    unlabelled = replace(rounded, label=-1, silent=np.ones(10, np.bool_))
    assert annotate([unlabelled], {"m7": track}, there, "ada", SIZE).same == 1, "no word about the class"
    outside = replace(track, boxes=track.boxes - [100, 0, 60, 0])
    cut = replace(outside, boxes=np.clip(outside.boxes, 0, 320))
    assert annotate([cut], {"m7": outside}, there, "ada", SIZE).same == 1, "importers cut at the picture's edge"


def test_a_note_alone_is_imported_once() -> None:
    track = line("m7", notes=((3, "bent"),))
    there = {"m7": engine_doc(7, 0, 9)}
    found = annotate([track], {"m7": line("m7")}, there, "ada", SIZE)
    assert (found.changed, found.same) == (1, 0)
    noted = found.documents["m7"]
    assert [(note.frame, note.text, note.author) for note in noted.notes] == [(3, "bent", "ada")]
    assert noted.model_copy(update={"notes": ()}) == there["m7"], "its boxes stay the engine's"
    assert annotate([track], {"m7": track}, {"m7": noted}, "ada", SIZE).same == 1, "it is there already"


def test_no_class_is_a_correction_and_the_engines_class_is_not() -> None:
    there, run = {"m7": engine_doc(7, 0, 9)}, {"m7": line("m7")}
    none = annotate([line("m7", label=-1)], run, there, "ada", SIZE).documents["m7"]
    assert none == engine_doc(7, 0, 9).model_copy(update={"class_id": NO_CLASS})
    assert annotate([line("m7", label=-1)], {"m7": line("m7", label=-1)}, {"m7": none}, "ada", SIZE).same == 1
    back = annotate(
        [line("m7")], {"m7": line("m7", label=-1)}, {"m7": none}, "ada", SIZE, engine={7: EngineTrackInfo(14, (0, 9))}
    )
    assert back.documents["m7"] == engine_doc(7, 0, 9)
    never = {"m7": line("m7", label=-1)}
    assert annotate([line("m7", label=-1)], never, there, "ada", SIZE).same == 1, "the engine has read none either"
    some = np.where(np.arange(10) == 4, -1, 14)
    assert annotate([line("m7", labels=some)], run, there, "ada", SIZE).documents["m7"].keys["4"].class_id == NO_CLASS


@pytest.mark.parametrize(
    "change",
    [
        {"label": 13},
        {"boxes": line().boxes + 0.2},
        {"occluded": np.ones(10, np.bool_)},
        {"state": "accepted"},
        {"frames": np.arange(1, 11)},
    ],
    ids=["label", "box", "hidden", "state", "frames"],
)
def test_a_track_of_the_run_is_corrected_from_the_file(change: dict[str, object]) -> None:
    before = engine_doc(7, 0, 9).model_copy(update={"revision": 4, "review": "needs_work"})
    track = replace(line("m7"), **change)  # type: ignore[arg-type]
    found = annotate([track], {"m7": line("m7")}, {"m7": before}, "ada", SIZE)
    assert (found.changed, found.made, list(found.documents)) == (1, 0, ["m7"])
    whole = 14 if found.documents["m7"].class_id is None else found.documents["m7"].class_id
    assert whole == track.label
    assert_same_track(replace(shown_track(found.documents["m7"], line("m7")), label=whole, labels=None), track, 0.5)
    assert found.documents["m7"].revision == 4
    assert found.documents["m7"].review == ("accepted" if track.state == "accepted" else "needs_work")


def test_an_unnamed_track_is_matched_by_position() -> None:
    run = {"m7": line("m7"), "m8": replace(line("m8"), boxes=line().boxes + 100)}
    near = replace(line("a"), boxes=line().boxes + 2, label=3)
    late = line("b", frames=range(6, 10))
    far = replace(line("c"), boxes=line().boxes + 40)
    found = annotate([late, near, far], run, {}, "ada", SIZE)
    assert (found.changed, found.made, found.same) == (1, 2, 0), "one to one: the one with most frames in common"
    assert "m7" in found.documents
    assert found.documents["m7"].class_id == 3
    assert "m8" not in found.documents
    rejected = {"m7": replace(run["m7"], state="rejected")}
    assert annotate([near], rejected, {}, "ada", SIZE).made == 1, "what was judged to be no sign is not brought back"


def test_names_match_in_exports_of_the_run_and_else_if_boxes_agree() -> None:
    run = {"m1": line("m1"), "m2": replace(line("m2"), boxes=line().boxes + 100)}
    redrawn = replace(line("m1"), boxes=line().boxes + 12, label=3)  # too far away to be matched by position
    assert list(annotate([redrawn], run, {}, "ada", SIZE).documents) == ["m1"]
    other = replace(line("m1"), boxes=line().boxes + 101, label=3)  # the m1 of another run is our m2
    assert list(annotate([other], run, {}, "ada", SIZE).documents) == ["m2"]
    named = annotate([other], run, {}, "ada", SIZE, exported=True).documents
    assert (list(named), named["m2"].merged_into) == (["m1", "m2"], "m1"), "one sign is not there twice"
    gone = {"m3": TrackDoc(key="m3", gone=True)}
    assert annotate([line("m3")], {}, gone, "ada", SIZE).made == 1
    assert list(annotate([line("m3")], {}, gone, "ada", SIZE, exported=True).documents) == ["m3"]


def parts(*spans: range) -> dict[str, Track]:
    """A sign that the engine lost and found again."""
    return {f"m{2 + 4 * k}": line(f"m{2 + 4 * k}", frames=span) for k, span in enumerate(spans)}


def test_tracks_merged_in_the_file_are_merged() -> None:
    run = parts(range(5), range(5, 8), range(8, 10)) | {"m30": replace(line("m30"), boxes=line().boxes + 100)}
    found = annotate([line("x", label=3)], run, {}, "ada", SIZE)
    assert (found.changed, found.made, sorted(found.documents)) == (1, 0, ["m10", "m2", "m6"])
    whole = found.documents["m2"]
    assert (whole.keys, whole.class_id) == ({}, 3), "their boxes go on coming from the engine"
    assert [(s.track, s.first, s.last) for s in whole.segments] == [(2, 0, 4), (6, 5, 7), (10, 8, 9)]
    assert [found.documents[key].merged_into for key in ("m6", "m10")] == ["m2", "m2"]
    assert all(found.documents[key].gone for key in ("m6", "m10"))
    assert found.repaired == ["Tracks #6, #10 of the run also lie on tracks of the file and were merged into them."]
    moved = line("x", boxes=line().boxes + np.where(np.arange(10) == 6, 2, 0)[:, None])
    (corrected,) = [doc for doc in annotate([moved], run, {}, "ada", SIZE).documents.values() if not doc.gone]
    assert corrected.frames() == [6]


def test_an_edited_part_is_kept_and_reported() -> None:
    run = parts(range(6), range(6, 10))
    engine = {2: EngineTrackInfo(14, (0, 5)), 6: EngineTrackInfo(14, (6, 9))}
    said = {"m6": engine_doc(6, 6, 9).model_copy(update={"review": "accepted"})}
    found = annotate([line("x", label=3)], run, said, "ada", SIZE, engine=engine)
    assert list(found.documents) == ["m2"]
    assert [skipped.what for skipped in found.skipped] == ["track #6 of the run"]
    undone = {"m6": engine_doc(6, 6, 9).model_copy(update={"revision": 2})}
    merged = annotate([line("x", label=3)], run, undone, "ada", SIZE, engine=engine).documents["m6"]
    assert (merged.gone, merged.revision) == (True, 2)


def test_existing_duplicates_and_neighbours_are_kept() -> None:
    run = parts(range(10)) | {"m6": replace(line("m6", frames=range(3, 8)), boxes=line(frames=range(3, 8)).boxes + 1)}
    assert list(annotate([line("x", label=3)], run, {}, "ada", SIZE).documents) == ["m2"]
    both = parts(range(5), range(5, 20))
    assert list(annotate([line("x", label=3)], both, {}, "ada", SIZE).documents) == ["m2"], "most of it is its own"
    file = [line("m2", frames=range(5)), line("m6", frames=range(5, 10), label=3)]
    assert list(annotate(file, parts(range(5), range(5, 10)), {}, "ada", SIZE).documents) == ["m6"]


def test_importing_again_changes_nothing() -> None:
    wavy = replace(line(frames=range(30)), boxes=line(frames=range(30)).boxes + 0.4 * np.sin(np.arange(30))[:, None])
    first = annotate([wavy], {}, {}, "ada", SIZE)
    ((key, document),) = first.documents.items()
    assert 1 < len(document.keys) < 30
    again = annotate([wavy], {key: replace(shown_track(document), uid=key)}, {key: document}, "bob", SIZE)
    assert (again.same, again.documents, again.repaired) == (1, {}, [])


def test_whole_pixel_boxes_have_limited_precision() -> None:
    track = line("m7")
    track = replace(track, boxes=track.boxes + 0.3)
    rounded = replace(track, boxes=np.rint(track.boxes))
    there = {"m7": engine_doc(7, 0, 9)}
    assert annotate([rounded], {"m7": track}, there, "ada", SIZE).same == 1
    moved = rounded.boxes.copy()
    moved[4] += 1
    assert annotate([replace(rounded, boxes=moved)], {"m7": track}, there, "ada", SIZE).changed == 1


def test_two_tracks_of_one_name_do_not_overwrite_each_other() -> None:
    found = annotate([line("m7", label=3), line("m7", label=4)], {"m7": line("m7")}, {}, "ada", SIZE)
    assert len(found.documents) == 2


def test_ground_truth_numbers_follow_the_names() -> None:
    assert track_numbers(["m7", "t007", "12", "abc", "x1y", "m1"]) == {
        "m7": 7,
        "t007": 2,
        "12": 12,
        "abc": 3,
        "x1y": 4,
        "m1": 1,
    }


def test_ground_truth_rows_keep_all_their_fields() -> None:
    hidden, ignore = np.arange(10) == 3, np.arange(10) == 4
    rows = ground_truth_rows([line("m2", label=-1, ignore=ignore), line("m1", occluded=hidden)])
    assert rows.shape == (20, 9)
    assert rows[:, 0].tolist() == sorted([*range(10)] * 2)
    assert rows[:2, 1].tolist() == [1, 2]
    assert rows[rows[:, 1] == 1][:, 7].tolist() == [0.0 if k == 3 else 1.0 for k in range(10)]
    assert rows[rows[:, 1] == 2][:, 8].tolist() == [1.0 if k == 4 else 0.0 for k in range(10)]
    assert ground_truth_rows([]).shape == (0, 9)
