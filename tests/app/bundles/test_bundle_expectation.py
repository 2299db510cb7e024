"""The expectation that a bundle derives from corrections."""

from __future__ import annotations

from typing import Any

from app.bundles.expectation import expectation_of
from app.edits.documents import NO_CLASS, KeyFrame, Segment, TrackDoc
from tests.app.bundles.toy_bundle import LABEL, WRONG, corrections, sign_box
from tsr_engine.bundle import Expectation


def expected(home: Any, *documents: TrackDoc, first: int = 46, stop: int = 70, keys: Any = ()) -> Expectation:
    with home.reader() as reader:
        return expectation_of(reader, {doc.key: doc for doc in documents}, first, stop, keys)


def ids(expectation: Expectation) -> list[str]:
    return [one.id for one in expectation.expected]


def whole_track(track: int = 2, first: int = 44, last: int = 74, **more: Any) -> TrackDoc:
    return TrackDoc(key=f"m{track}", segments=(Segment(track=track, first=first, last=last),), **more)


def test_label_boxes_and_a_missed_sign(home: Any) -> None:
    found = expected(home, *corrections())
    assert ids(found) == ["habcdef.found", "habcdef.label", "m2.label", "m2.boxes"]
    assert [one.class_id for one in found.expected] == [None, WRONG, WRONG, None]
    assert found.expected[3].frames == [50, 60]
    assert found.signs["m2"].frames == list(range(46, 70))
    assert found.signs["m2"].boxes[4] == sign_box(50)
    assert found.signs["habcdef"].frames == list(range(46, 62))  # hidden from 62 on
    assert found.signs["habcdef"].boxes[0] == (7.0, 2.0, 17.0, 12.0)  # interpolated between two key frames


def test_only_some_tracks(home: Any) -> None:
    assert ids(expected(home, *corrections(), keys={"m2"})) == ["m2.label", "m2.boxes"]
    assert ids(expected(home, *corrections(), keys={"m1"})) == []


def test_tracks_that_are_not_signs(home: Any) -> None:
    for document in (whole_track(not_a_sign=True), whole_track(review="rejected"), TrackDoc(key="m2", gone=True)):
        found = expected(home, document)
        assert ids(found) == ["m2.absent"]
        assert found.signs["m2"].frames == list(range(46, 70))
    assert ids(expected(home, TrackDoc(key="h1234567", gone=True))) == []


def test_deleted_from_a_frame_on(home: Any) -> None:
    found = expected(home, whole_track(last=55))
    assert ids(found) == ["m2 cut.absent"]
    assert found.signs["m2 cut"].frames == list(range(56, 70))


def test_a_rejected_second_track_on_a_kept_sign(home: Any) -> None:
    own = TrackDoc(key="h1234567", keys={str(k): KeyFrame(box=sign_box(k)) for k in range(46, 70)})
    found = expected(home, TrackDoc(key="m2", gone=True), own)
    assert ids(found) == ["h1234567.found", "h1234567.one"]


def test_merged_and_split(home: Any) -> None:
    merged = TrackDoc(key="m1", segments=(Segment(track=1, first=4, last=50), Segment(track=2, first=51, last=74)))
    gone = TrackDoc(key="m2", gone=True, merged_into="m1")
    assert ids(expected(home, merged, gone)) == ["m1.one"]
    halves = whole_track(last=57), TrackDoc(key="h7654321", segments=(Segment(track=2, first=58, last=74),))
    found = expected(home, *halves)
    assert ids(found) == ["h7654321.apart.m2"]
    assert (found.signs["m2"].frames[-1], found.signs["h7654321"].frames[0]) == (57, 58)


def test_accepted_tracks_must_stay_unchanged(home: Any) -> None:
    found = expected(home, whole_track(review="accepted"), stop=75)
    assert ids(found) == ["m2.found", "m2.label"]
    assert found.expected[1].class_id == LABEL


def test_an_uncorrected_label_is_expected_only_after_all_votes(home: Any) -> None:
    assert ids(expected(home, whole_track(review="accepted"), stop=70)) == ["m2.found"]
    corrected = expected(home, whole_track(review="accepted", class_id=WRONG), stop=70)
    assert ids(corrected) == ["m2.found", "m2.label"]  # that is the bug
    ended = expected(home, whole_track(review="accepted", last=69), stop=70)  # a person set its end
    assert ids(ended) == ["m2.found", "m2.label"]


def test_no_class_expects_no_label(home: Any) -> None:
    assert ids(expected(home, whole_track(class_id=NO_CLASS))) == []
    assert ids(expected(home, whole_track(class_id=NO_CLASS, review="accepted"))) == ["m2.found"]


def test_hidden_frames_expect_nothing(home: Any) -> None:
    keys = {"50": KeyFrame(box=sign_box(50), occluded=True), "60": KeyFrame(box=sign_box(60))}
    found = expected(home, whole_track(keys=keys))
    assert found.signs["m2"].hidden == list(range(50, 60))
    assert [one.frames for one in found.expected] == [[60]]


def test_without_corrections_nothing_is_expected(home: Any) -> None:
    assert expected(home) == Expectation()
    assert ids(expected(home, whole_track())) == []
    assert ids(expected(home, *(whole_track(class_id=WRONG),), first=0, stop=40)) == []
