"""Attributes and ignored regions: which edits keep them, their storage, and the label set's rules."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from app.edits.adopt import EngineRun, adopt_documents
from app.edits.commands import Command, Undo
from app.edits.documents import KeyFrame, TrackDoc
from app.edits.effective import box_at
from app.errors import Invalid
from tests.app.edits.edit_services import EditServices, make_edit_services
from tests.app.edits.random_commands import engine_box, initial_documents
from tests.app.edits.test_apply import apply, walk
from tsr_engine.labels.files import DEFAULT, shipped_set
from tsr_engine.labels.model import Attribute, Label, LabelSet

ADAPTER: TypeAdapter[Any] = TypeAdapter(Command)
BOX = [0.0, 0.0, 9.0, 9.0]
ATTRIBUTES = (
    Attribute(name="temporary", kind="checkbox", mutable=True),
    Attribute(name="lit", kind="select", values=("day", "night")),
    Attribute(name="metres", kind="number", low=0, high=90),
)


def attribute(name: str, value: Any, frame: int | None = None, key: str = "m1") -> dict[str, Any]:
    where = {"frame": 3} if frame is None else {"frame": frame, "from_here": True}
    return {"name": "attribute", "key": key, "attribute": name, "value": value, **where}


def values(doc: TrackDoc, name: str, *frames: int) -> list[Any]:
    return [doc.attributes_at(frame).get(name) for frame in frames]


def test_a_value_from_a_frame_on_lasts_until_the_next_value() -> None:
    docs = apply(initial_documents(), **attribute("state", "old"))
    docs = apply(docs, **attribute("state", "new", 10))
    docs = apply(docs, **attribute("state", "worn", 15))
    assert values(docs["m1"], "state", 0, 9, 10, 14, 15, 20) == ["old", "old", "new", "new", "worn", "worn"]
    docs = apply(docs, **attribute("state", "red", 5))
    assert values(docs["m1"], "state", 4, 5, 10, 15) == ["old", "red", "new", "worn"]
    docs = apply(docs, **attribute("state", None, 10))
    assert values(docs["m1"], "state", 5, 10, 14, 15) == ["red", "old", "old", "worn"]
    docs = apply(docs, **attribute("state", "whole"))
    assert docs["m1"] == initial_documents()["m1"].model_copy(update={"attributes": {"state": "whole"}})
    docs = apply(docs, **attribute("state", None))
    assert docs == initial_documents()


def test_a_value_continues_over_key_frames_without_it() -> None:
    docs = apply(initial_documents(), name="set_box", key="m1", frame=10, box=BOX)
    docs = apply(docs, **attribute("temporary", True, 5))
    assert values(docs["m1"], "temporary", 4, 5, 10, 20) == [None, True, True, True]
    assert docs["m1"].keys["10"].box == tuple(BOX)
    docs = apply(docs, **attribute("lanes", 1, 5))
    assert apply(docs, **attribute("lanes", True, 10))["m1"].attributes_at(20)["lanes"] is True, "true is not 1"


def test_a_key_frame_for_an_attribute_leaves_the_box_to_the_engine() -> None:
    docs = apply(initial_documents(), **attribute("temporary", True, 10))
    shown = box_at(docs["m1"], 10, engine_box)
    assert shown is not None
    assert shown.origin == "engine"


def test_edits_that_keep_attributes() -> None:
    docs = apply(initial_documents(), **attribute("temporary", True, 10))
    docs = apply(docs, **attribute("lit", "night"))
    docs = apply(docs, name="ignore", key="m1", frame=0, value=True)
    split = apply(docs, name="split", key="m1", frame=15, new_key="hlater01")
    late = split["hlater01"]
    assert (late.ignore, late.attributes_at(18)) == (True, {"lit": "night", "temporary": True})
    assert split["m1"].attributes_at(12) == {"lit": "night", "temporary": True}
    back = apply(split, name="merge", key="m1", others=["hlater01"], frame=15)["m1"]
    assert [back.attributes_at(frame) for frame in range(21)] == [docs["m1"].attributes_at(f) for f in range(21)]
    merged = apply(docs, name="merge", key="m3", others=["m1"], frame=60)["m3"]
    assert merged.attributes_at(12) == {"lit": "night", "temporary": True}
    assert merged.attributes_at(60) == {"lit": "night"}
    assert not merged.ignore
    assert apply(docs, name="relabel_track", key="m1", frame=0, class_id=3)["m1"].attributes_at(12)["temporary"] is True
    moved = apply(docs, name="set_box", key="m1", frame=14, box=BOX)["m1"]
    assert values(moved, "temporary", 9, 14, 20) == [None, True, True]


def test_following_again_keeps_attributes() -> None:
    def follow(*frames: int) -> dict[str, Any]:
        boxes = [{"frame": frame, "box": BOX, "anchor": frame == frames[0]} for frame in frames]
        return {"name": "follow", "key": "m1", "frame": 0, "boxes": boxes}

    docs = apply(apply(initial_documents(), **follow(0, 4, 8, 12)), **attribute("temporary", True, 8))
    again = apply(docs, **follow(0, 6, 12))["m1"]
    assert values(again, "temporary", 6, 7, 8, 12) == [None, None, True, True]
    assert again.line_at(8) == tuple(BOX)


def test_documents_without_attributes_are_stored_as_before() -> None:
    old = Path(__file__).parents[2] / "golden" / "edits" / "random.json"
    for case in json.loads(old.read_text())["cases"]:
        for stored in case["docs"].values():
            doc = TrackDoc.model_validate(stored)
            assert doc.model_dump(mode="json") == stored
            assert doc.attributes == {}
            assert not doc.ignore
    doc = apply(apply(initial_documents(), **attribute("a", True, 10)), name="ignore", key="m1", frame=0, value=True)[
        "m1"
    ]
    stored = json.loads(json.dumps(doc.model_dump(mode="json")))
    assert (stored["ignore"], stored["keys"]["10"]["attributes"], "attributes" in stored) == (True, {"a": True}, False)
    assert TrackDoc.model_validate(stored) == doc


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), value=st.sampled_from([True, False, 1.0, -2.5, "", "é 🚸 <b>"]))
def test_a_value_round_trips(seed: int, value: Any) -> None:
    docs = walk(seed, 10)
    key = next((key for key, doc in docs.items() if not doc.gone), None)
    if key is None:
        return
    doc = apply(docs, **attribute("a", value, key=key))[key]
    read = TrackDoc.model_validate_json(doc.model_dump_json())
    assert (read, type(read.attributes["a"])) == (doc, type(value))


@pytest.mark.parametrize("bad", [[1], {}, float("nan"), float("inf"), "x" * 1001, "\x00"])
def test_invalid_values_are_refused(bad: Any) -> None:
    with pytest.raises(ValidationError):
        KeyFrame(attributes={"a": bad})
    with pytest.raises(ValidationError):
        TrackDoc.model_validate({"key": "m1", "attributes": {"a": bad}})


def test_adoption_includes_attributes() -> None:
    frame = np.arange(20)
    run = EngineRun(frame, np.full(20, 1), np.tile([0.0, 0.0, 30.0, 30.0], (20, 1)), np.full(20, 14))
    doc = initial_documents()["m1"].model_copy(update={"attributes": {"lit": "night"}, "ignore": True})
    adoption = adopt_documents({"m1": doc}, run, run, {}, 20)
    (kept,) = adoption.changed["m1"].values()
    assert (kept.attributes, kept.ignore) == ({"lit": "night"}, True)
    assert not doc.untouched((0, 20))


@pytest.fixture
def labelled(database_url: str) -> Iterator[EditServices]:
    """A service whose videos have a set with more labels than the shipped one, two of them with attributes."""
    gtsrb = shipped_set(DEFAULT)
    stop = gtsrb.labels[14].model_copy(update={"attributes": ATTRIBUTES})
    hidden = Label(id=60, key="bus-stop", name="bus stop", hidden=True)
    merged = Label(id=61, key="halt-here", name="halt here", merged_into=14)
    known = (*gtsrb.labels[:14], stop, *gtsrb.labels[15:], hidden, merged)
    labels = LabelSet(key="ours", name="Ours", next_id=62, labels=known)
    services = make_edit_services(database_url, labels)
    yield services
    services.database.close()


def send(edits: EditServices, op: int, raw: dict[str, Any], revision: int = 0) -> TrackDoc:
    command = ADAPTER.validate_python({"frame": 3, "key": "m1", **raw})
    return edits.service.apply(edits.run, f"op-{op:08}", "ann", command, {command.key: revision}).docs[0]


def test_only_labels_of_the_set_are_accepted(labelled: EditServices) -> None:
    for revision, label in enumerate((60, 61, -1, 42, None)):
        assert send(labelled, revision, {"name": "relabel_track", "class_id": label}, revision).class_id == label
    for name in ("relabel_track", "relabel_box"):
        with pytest.raises(Invalid, match="'ours' has no label 62") as caught:
            send(labelled, 9, {"name": name, "class_id": 62}, 5)
        assert (caught.value.code, caught.value.field) == ("no_such_label", "command.class_id")
    stray = TrackDoc(key="hstray01", class_id=43, keys={"3": KeyFrame(box=(0.0, 0.0, 9.0, 9.0))})
    with pytest.raises(Invalid, match="Track hstray01: the label set 'ours' has no label 43"):
        labelled.bulk.put_documents(labelled.run, "ann", {"name": "import"}, lambda _: {"hstray01": stray})


def test_an_id_of_another_set_is_found_by_the_key_of_its_label(labelled: EditServices) -> None:
    """The sender may have seen the video's previous label set."""
    given = {"name": "relabel_track", "class_id": 43}
    assert send(labelled, 1, {**given, "label_key": "bus-stop"}).class_id == 60
    assert send(labelled, 2, {**given, "class_id": 5, "label_key": "STOP"}, 1).class_id == 14, "5 is another label here"
    drawn = {"name": "create_track", "key": "hdrawn01", "box": BOX, "class_id": 0, "label_key": "yield-here"}
    for op, raw in enumerate((drawn, {**given, "class_id": 14, "label_key": "yield-here"})):
        with pytest.raises(
            Invalid, match="The label set 'Ours', which the video uses now, has no label 'yield-here'"
        ) as e:
            send(labelled, 10 + op, raw, 2 if raw is not drawn else 0)
        assert e.value.code == "no_such_label"
    assert send(labelled, 3, {**given, "class_id": -1, "label_key": "yield-here"}, 2).class_id == -1
    again = Undo(name="undo", op_id="op-00000003")
    assert labelled.service.apply(labelled.run, "op-undo-0001", "ann", again, None).docs[0].class_id == 14


def test_only_attributes_of_the_label_are_accepted(labelled: EditServices) -> None:
    doc = send(labelled, 1, {"name": "attribute", "attribute": "lit", "value": "night"})
    doc = send(labelled, 2, {"name": "attribute", "attribute": "metres", "value": 40}, 1)
    doc = send(labelled, 3, {"name": "attribute", "attribute": "temporary", "value": True, "from_here": True}, 2)
    assert doc.attributes_at(3) == {"lit": "night", "metres": 40.0, "temporary": True}
    for raw, sentence in (
        ({"attribute": "lit", "value": "dusk"}, "must be one of day, night"),
        ({"attribute": "metres", "value": 91}, "must be within 0.0 and 90.0"),
        ({"attribute": "metres", "value": True}, "must be a number"),
        ({"attribute": "lit", "value": "day", "from_here": True}, "one value for the whole track"),
        ({"attribute": "colour", "value": "red"}, "'stop' has no attribute 'colour'"),
    ):
        with pytest.raises(Invalid, match=sentence):
            send(labelled, 9, {"name": "attribute", **raw}, 3)
    with pytest.raises(Invalid, match="Track m2 has no label of the set 'ours'"):
        send(labelled, 9, {"name": "attribute", "key": "m2", "attribute": "lit", "value": "day"})
    send(labelled, 4, {"name": "relabel_track", "class_id": 61}, 3)
    send(labelled, 5, {"name": "attribute", "attribute": "lit", "value": "day"}, 4)
    undone = labelled.service.apply(labelled.run, "op-undo-0001", "ann", Undo(name="undo", op_id="op-00000005"), None)
    assert undone.docs[0].attributes == {"lit": "night", "metres": 40.0}
    send(labelled, 6, {"name": "relabel_track", "class_id": 3}, undone.docs[0].revision)
    gone = send(labelled, 7, {"name": "attribute", "attribute": "lit", "value": None}, undone.docs[0].revision + 1)
    assert gone.attributes == {"metres": 40.0}, "what a label lacks can be taken away"
