"""Effects of commands: golden cases, and properties of every sequence."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from app.edits.apply import CommandError, apply_command, touched_keys, with_gaps
from app.edits.commands import Command
from app.edits.documents import NO_CLASS, OPEN_END, KeyFrame, TrackDoc, engine_doc
from app.edits.effective import Effective, box_at, effective_track
from tests.app.edits.random_commands import (
    SPANS,
    engine_box,
    engine_gaps,
    initial_documents,
    interrupted_lines,
    random_command,
)

ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)
GOLDEN = [
    case
    for file in sorted((Path(__file__).parents[2] / "golden" / "edits").glob("*.json"))
    for case in json.loads(file.read_text())["cases"]
]


def box_shown(doc: TrackDoc, frame: int) -> Effective | None:
    return box_at(doc, frame, engine_box)


def is_near(a: Effective | None, b: Effective | None) -> bool:
    """The same except for the source of boxes: a cut line gets a key frame at the cut."""
    if a is None or b is None:
        return a is b
    return a.box == pytest.approx(b.box) and a.occluded == b.occluded


def apply(docs: dict[str, TrackDoc], **command: Any) -> dict[str, TrackDoc]:
    return {**docs, **apply_command(docs, ADAPTER.validate_python(command), "ann", "now")}


def walk(seed: int, length: int) -> dict[str, TrackDoc]:
    rng, docs = random.Random(seed), initial_documents()
    for step in range(length):
        try:
            docs = apply(docs, **random_command(rng, docs, step))
        except CommandError:
            continue
    return docs


@pytest.mark.parametrize("case", GOLDEN, ids=lambda case: case["name"])
def test_commands_have_the_golden_effect(case: dict[str, Any]) -> None:
    docs = {key: TrackDoc.model_validate(doc) for key, doc in case["docs"].items()}
    command = ADAPTER.validate_python(case["command"])
    if "error" in case:
        with pytest.raises(CommandError) as caught:
            apply_command(docs, command, **case["person"])
        assert str(caught.value) == case["error"]
        return
    changed = apply_command(docs, command, **case["person"])
    assert {key: doc.model_dump(mode="json") for key, doc in changed.items()} == case["expected"]
    assert set(changed) <= set(touched_keys(command))


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(0, 12), whole=st.booleans())
def test_deleted_parts_are_restored_unchanged(seed: int, length: int, whole: bool) -> None:
    docs = walk(seed, length)
    for key, doc in docs.items():
        if doc.gone or not doc.shows_from(0):
            continue
        away = {"name": "delete_track", "frame": 3} if whole else {"name": "delete_from", "frame": 0}
        gone = apply(docs, key=key, **away)
        assert gone[key].gone
        assert apply(gone, name="restore_track", key=key, frame=3)[key] == doc


def test_only_deleted_tracks_can_be_restored() -> None:
    docs = apply(initial_documents(), name="merge", key="m1", frame=0, others=["m2"])
    docs["hundone1"] = TrackDoc(key="hundone1", gone=True)
    for key, why in (("m1", "not deleted"), ("m2", "merged into track m1"), ("hundone1", "Nothing is left")):
        with pytest.raises(CommandError, match=why):
            apply(docs, name="restore_track", key=key, frame=0)
    with pytest.raises(CommandError, match="Restore it first"):
        apply(apply(docs, name="delete_track", key="m1", frame=0), name="set_review", key="m1", frame=0, review="open")


@settings(max_examples=80, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(0, 12), frame=st.integers(1, 74))
def test_split_and_delete_keep_the_shown_boxes(seed: int, length: int, frame: int) -> None:
    docs = walk(seed, length)
    for key, doc in docs.items():
        if not doc.gone:
            assert_cut_keeps_the_shown_boxes(docs, key, frame)


def assert_cut_keeps_the_shown_boxes(docs: dict[str, TrackDoc], key: str, frame: int) -> None:
    doc = docs[key]
    try:
        cut = apply(docs, name="delete_from", key=key, frame=frame)[key]
    except CommandError:
        assert not any(box_shown(doc, f) for f in range(frame, 76)), "nothing to delete"
        cut = doc
    for f in range(76):
        assert is_near(box_shown(cut, f), box_shown(doc, f) if f < frame else None), (key, f)
    try:
        parts = apply(docs, name="split", key=key, frame=frame, new_key="hlater1")
    except CommandError:
        return
    for f in range(76):
        assert is_near(box_shown(parts[key], f), box_shown(doc, f) if f < frame else None), (key, f)
        assert is_near(box_shown(parts["hlater1"], f), box_shown(doc, f) if f >= frame else None), (key, f)


KEY_FRAMES = st.builds(
    KeyFrame,
    box=st.none() | st.integers(0, 300).map(lambda x: (float(x), 0.0, x + 20.0, 20.0)),
    interpolate=st.booleans(),
    outside=st.sampled_from([False, False, True]),
    occluded=st.booleans(),
)


@settings(max_examples=150, deadline=None)
@given(keys=st.dictionaries(st.integers(0, 24).map(str), KEY_FRAMES, max_size=7), frame=st.integers(1, 24))
@example(  # frames 5 to 9 are the engine's
    keys={
        "2": KeyFrame(box=(0.0, 0.0, 20.0, 20.0), interpolate=True),
        "5": KeyFrame(),
        "10": KeyFrame(interpolate=True),
        "15": KeyFrame(box=(130.0, 0.0, 150.0, 20.0)),
    },
    frame=8,
)
def test_cuts_keep_the_boxes_of_lines_with_gaps(keys: dict[str, KeyFrame], frame: int) -> None:
    docs = {"m1": engine_doc(1, *SPANS[1]).model_copy(update={"keys": keys})}
    assert_cut_keeps_the_shown_boxes(docs, "m1", frame)


@pytest.mark.parametrize("frame", [12, 13])
def test_a_line_cut_at_a_key_frame_without_a_box_keeps_its_boxes(frame: int) -> None:
    docs = apply(initial_documents(), name="set_occluded", key="m1", frame=12, value=True)
    docs = apply(docs, name="set_box", key="m1", frame=3, box=[0, 0, 10, 10])
    docs = apply(docs, name="set_box", key="m1", frame=20, box=[170, 0, 180, 10])
    docs = apply(docs, name="interpolate", key="m1", frame=3, first=3, last=20)
    cut = apply(docs, name="delete_from", key="m1", frame=frame)["m1"]
    parts = apply(docs, name="split", key="m1", frame=frame, new_key="hlater1")
    for f in range(21):
        whole = box_shown(docs["m1"], f)
        assert is_near(box_shown(cut, f), whole if f < frame else None), f
        assert is_near(box_shown(parts["m1"], f), whole if f < frame else None), f
        assert is_near(box_shown(parts["hlater1"], f), whole if f >= frame else None), f


@pytest.mark.parametrize(("key", "frame"), [("m1", 9), ("m1", 12), ("m2", 23), ("m2", 27), ("m2", 30)])
def test_a_cut_beside_an_interrupted_line_keeps_its_boxes(key: str, frame: int) -> None:
    docs = initial_documents()
    for command in interrupted_lines([0.0, 0.0, 10.0, 10.0], [150.0, 0.0, 160.0, 10.0]):
        docs = apply(docs, **command)
    assert [f for f in range(41) if (s := box_shown(docs["m1"], f)) and s.origin == "interpolated"] == [*range(4, 9)]
    assert [f for f in range(41) if (s := box_shown(docs["m2"], f)) and s.origin == "interpolated"] == [*range(27, 35)]
    cut = apply(docs, name="delete_from", key=key, frame=frame)[key]
    parts = apply(docs, name="split", key=key, frame=frame, new_key="hlater1")
    for f in range(41):
        whole = box_shown(docs[key], f)
        assert is_near(box_shown(cut, f), whole if f < frame else None), f
        assert is_near(box_shown(parts[key], f), whole if f < frame else None), f
        assert is_near(box_shown(parts["hlater1"], f), whole if f >= frame else None), f


def test_a_half_without_boxes_of_the_engine_keeps_its_class() -> None:
    """m1 ends at frame 20 and people continued it; a drawn track has taken over the engine's m3 (50 to 70)."""
    docs = apply(initial_documents(), name="set_box", key="m1", frame=30, box=[0, 0, 9, 9])
    docs = apply(docs, name="set_box", key="m1", frame=40, box=[9, 0, 18, 9])
    docs = apply(docs, name="create_track", key="hdrawn1", frame=45, box=[0, 0, 9, 9])
    docs = apply(docs, name="merge", key="hdrawn1", frame=45, others=["m3"])
    behind = apply(docs, name="split", key="m1", frame=35, new_key="hlater1", class_id=14)
    assert not behind["hlater1"].segments
    assert (behind["m1"].class_id, behind["hlater1"].class_id) == (None, 14)
    before = apply(docs, name="split", key="hdrawn1", frame=48, new_key="hlater1", class_id=38)
    assert not before["hdrawn1"].segments
    assert (before["hdrawn1"].class_id, before["hlater1"].class_id) == (38, None)
    within = apply(docs, name="split", key="m1", frame=10, new_key="hlater1", class_id=14)
    assert within["hlater1"].class_id is None, "the engine's label comes with its piece"
    said = apply(docs, name="relabel_track", key="m1", frame=0, class_id=3)
    assert apply(said, name="split", key="m1", frame=35, new_key="hlater1", class_id=14)["hlater1"].class_id == 3
    # the form in logs and pages of older versions
    assert apply(docs, name="split", key="m1", frame=35, new_key="hlater1")["hlater1"].class_id is None


@pytest.mark.parametrize("key", ["m1", "hdrawn1"])
def test_a_half_of_another_engine_track_keeps_the_label_of_the_whole(key: str) -> None:
    """The whole shows the label of m1, 14, also in the frames of m3."""
    docs = apply(initial_documents(), name="create_track", key="hdrawn1", frame=45, box=[0, 0, 9, 9])
    for other in {"m1", "m3"} - {key}:
        docs = apply(docs, name="merge", key=key, frame=45, others=[other])
    docs[key] = docs[key].model_copy(update={"class_id": None})
    halves = apply(docs, name="split", key=key, frame=50, new_key="hlater1", class_id=14)
    assert [s.track for s in halves["hlater1"].segments] == [3]
    assert (halves[key].class_id, halves["hlater1"].class_id) == (None, 14)


@pytest.mark.parametrize(
    ("command", "why"),
    [
        ({"name": "delete_from"}, "There is nothing to delete"),
        ({"name": "set_outside", "value": True}, "outside already"),
        ({"name": "set_outside", "value": False}, "Nothing could come back into view"),
    ],
)
def test_nothing_can_be_removed_after_the_end_of_a_track(command: dict[str, Any], why: str) -> None:
    docs = apply(initial_documents(), name="create_track", key="hdrawn01", frame=10, box=[1.0, 1.0, 9.0, 9.0])
    docs = apply(docs, name="set_outside", key="m2", frame=30, value=True)
    for key, frame in (("m1", 21), ("m1", 40), ("hdrawn01", 11), ("m2", 41)):
        with pytest.raises(CommandError, match=f"Track {key} shows nothing from frame {frame} on. .*{why}"):
            apply(docs, key=key, frame=frame, **command)
    if command["name"] == "set_outside":
        back = apply(docs, name="set_outside", key="m2", frame=35, value=False)
        assert box_shown(back["m2"], 36) is not None
    growing = {"m4": engine_doc(4, 0, OPEN_END)}
    for allowed in ({"name": "delete_from"}, {"name": "set_outside", "value": True}):
        assert apply(growing, key="m4", frame=500, **allowed)["m4"] != growing["m4"], "what its run adds"


@settings(max_examples=80, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(0, 12))
@example(seed=731732, length=3)  # the other end of the line would come only from the other track's boxes
@example(seed=664443, length=12)  # key frames before the first box
def test_merge_keeps_the_boxes_of_both(seed: int, length: int) -> None:
    docs = walk(seed, length)
    alive = [key for key, doc in docs.items() if not doc.gone]
    for key in alive:
        for other in alive:
            if key == other:
                continue
            command = ADAPTER.validate_python({"name": "merge", "key": key, "others": [other], "frame": 0})
            merged = {**docs, **apply_command(docs, with_gaps(docs, command, engine_gaps))}
            assert merged[other].gone
            assert merged[other].merged_into == key
            for f in range(76):
                first, second, now = (box_shown(d, f) for d in (docs[key], docs[other], merged[key]))
                assert is_near(now, second if first is None else first), (key, other, f)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(0, 12))
def test_whole_tracks_equal_single_frames(seed: int, length: int) -> None:
    import numpy as np

    def whole(track: int) -> Any:
        rows = [(f, box) for f in range(*SPANS[track]) if (box := engine_box(track, f)) is not None]
        last = SPANS[track][1]
        if (box := engine_box(track, last)) is not None:
            rows.append((last, box))
        return np.array([f for f, _ in rows]), np.array([box for _, box in rows])

    for doc in walk(seed, length).values():
        got = effective_track(doc, whole, 76)
        want = [(f, one) for f in range(76) if (one := box_shown(doc, f)) is not None]
        assert got.frame.tolist() == [f for f, _ in want]
        assert got.boxes.tolist() == [list(one.box) for _, one in want]
        assert got.occluded.tolist() == [one.occluded for _, one in want]


@settings(max_examples=80, deadline=None)
@given(seed=st.integers(0, 10**6), length=st.integers(0, 12), label=st.sampled_from([None, NO_CLASS, 3]))
def test_a_label_of_the_whole_track_changes_no_box(seed: int, length: int, label: int | None) -> None:
    docs = walk(seed, length)
    for key, doc in docs.items():
        if doc.gone:
            continue
        after = apply(docs, name="relabel_track", frame=10, key=key, class_id=label)[key]
        assert len(after.keys) <= len(doc.keys)
        for frame in range(75):
            a, b = box_shown(doc, frame), box_shown(after, frame)
            assert is_near(a, b)
            assert b is None or b.class_id == label


def test_a_key_frame_of_only_a_label_is_removed_with_it() -> None:
    docs = apply(initial_documents(), name="relabel_box", frame=8, key="m1", class_id=7)
    docs = apply(docs, name="set_occluded", frame=12, key="m1", value=True)
    docs = apply(docs, name="relabel_box", frame=12, key="m1", class_id=7)
    assert apply(docs, name="relabel_track", frame=10, key="m1", class_id=None)["m1"].keys == {
        "12": KeyFrame(occluded=True)
    }


def test_merging_an_ended_track_does_not_hide_the_other() -> None:
    docs = apply(initial_documents(), name="set_outside", key="m1", frame=18, value=True)
    docs = apply(docs, name="merge", key="m1", others=["m3"], frame=60)
    assert box_shown(docs["m1"], 17) is not None
    assert box_shown(docs["m1"], 19) is None
    assert box_shown(docs["m1"], 60) is not None


BOX = [0.0, 0.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("broken", "field"),
    [
        ({"box": [1, 0, 1, 1]}, "box"),
        ({"box": [0, 0, float("nan"), 1]}, "box"),
        ({"box": [0, 0, float("inf"), 1]}, "box"),
        ({"box": [0, 0, 1e9, 1]}, "box"),
        ({"box": ["0", 0, 1, 1]}, "box"),
        ({"box": [0, 0, 1]}, "box"),
        ({"frame": -1}, "frame"),
        ({"frame": 1.5}, "frame"),
        ({"frame": True}, "frame"),
        ({"key": "m-1"}, "key"),
        ({"key": "../etc"}, "key"),
        ({"surprise": 1}, "surprise"),
        ({"name": "explode"}, None),
    ],
)
def test_malformed_commands_name_the_field(broken: dict[str, Any], field: str | None) -> None:
    with pytest.raises(ValidationError) as caught:
        ADAPTER.validate_python({"name": "set_box", "frame": 1, "key": "m1", "box": BOX, **broken})
    assert field is None or any(field in error["loc"] for error in caught.value.errors())
