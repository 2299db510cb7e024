"""Label sets: refusals, search, and the round trip of their file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema_rs
import pytest
from pydantic import ValidationError

from tsr_engine.errors import InputError
from tsr_engine.labels.files import DEFAULT, SHIPPED, dump_set, parse_set, shipped_set
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import Attribute, Label, LabelSet
from tsr_engine.labels.schema import schema_text
from tsr_engine.recognition.gtsrb_classes import SIGN_CLASSES


def make_set(*labels: Label) -> LabelSet:
    return LabelSet(key="mine", name="Mine", next_id=100, labels=labels)


def make_label(number: int, key: str, **fields: Any) -> Label:
    return Label(id=number, key=key, name=fields.pop("name", key), **fields)


def test_the_default_set_is_the_43_of_the_engine() -> None:
    labels = shipped_set("gtsrb-43")
    assert [(label.id, label.name, label.short, label.shape) for label in labels] == [
        (sign.id, sign.name, sign.short, sign.shape) for sign in SIGN_CLASSES
    ]
    assert labels.by_key("Turn-Left-Ahead") == labels.get(34)
    assert labels.get(33).mirror == "turn-left-ahead"  # type: ignore[union-attr]


def test_a_set_round_trips_through_its_file() -> None:
    side = Attribute(name="side", kind="select", values=("left", "right"), default="left")
    mine = make_set(
        make_label(7, "nö parking", aliases=("停车",), attributes=(side,)), make_label(9, "x", merged_into=7)
    )
    text = dump_set(mine)
    assert parse_set(text, "x") == mine
    assert dump_set(parse_set(text, "x")) == text
    assert parse_set(b"\xef\xbb\xbf" + text.encode(), "x") == mine
    assert parse_set(dump_set(make_set()), "x") == make_set()


@pytest.mark.parametrize(
    ("labels", "reported"),
    [
        ((make_label(1, "a"), make_label(1, "b")), "one id: 1"),
        ((make_label(1, "Stop"), make_label(2, "stop")), "one key"),
        ((make_label(1, "a", aliases=("no parking",)), make_label(2, "No-Parking")), "names two labels"),
        ((make_label(1, "a", pinned=3), make_label(2, "b", pinned=3)), "one pinned digit: 3"),
        ((make_label(1, "a", merged_into=2), make_label(2, "b", merged_into=1)), "merged into itself"),
        ((make_label(1, "a", merged_into=5),), "which is no label"),
        ((make_label(100, "a"),), "next_id"),
    ],
)
def test_duplicates_are_refused(labels: tuple[Label, ...], reported: str) -> None:
    with pytest.raises(ValidationError, match=reported):
        make_set(*labels)


@pytest.mark.parametrize("name", ["", " a", "a\n", "a\u202eb", "a\x00"])
def test_names_are_one_line_of_plain_text(name: str) -> None:
    with pytest.raises(ValidationError):
        make_label(1, "a", name=name)


@pytest.mark.parametrize(
    ("fields", "reported"),
    [
        ({"kind": "select"}, "a select has values"),
        ({"kind": "text", "values": ("a",)}, "nothing else has"),
        ({"kind": "number", "low": 2.0, "high": 1.0}, "low is above high"),
        ({"kind": "number", "high": 1.0, "default": 2.0}, "must be within None and 1.0"),
        ({"kind": "checkbox", "default": "yes"}, "must be true or false"),
        ({"kind": "select", "values": ("a",), "default": "b"}, "must be one of a"),
        ({"kind": "text", "low": 0.0}, "only a number"),
    ],
)
def test_a_contradictory_attribute_is_refused(fields: dict[str, Any], reported: str) -> None:
    with pytest.raises(ValidationError, match=reported):
        Attribute(name="a", **fields)


def test_words_find_labels() -> None:
    finder = LabelFinder(
        make_set(
            make_label(1, "no-parking", aliases=("Parkverbot",), short="no park"),
            make_label(2, "speed-40", name="speed limit 40", short="40"),
            make_label(3, "old", merged_into=1),
            make_label(40, "forty"),
        )
    )

    def found(word: str) -> tuple[int, str] | None:
        match = finder.find(word)
        return None if match is None else (match.label.id, match.how)

    assert found("No Parking") == (1, "key")
    assert found("SPEED_LIMIT-40") == (2, "name")
    assert found("parkverbot") == (1, "alias")
    assert found("no.park") == (1, "short")
    assert found("old") == (1, "key")
    assert found("40") == (40, "number")
    assert found("#2") == found("class 2") == found("00002") == (2, "number")
    assert found("3") == (1, "number")
    assert found("give way") is None
    assert [label.id for label in finder.suggestions("parking").labels] == [1]
    assert finder.suggestions("zebra").labels == ()


PARTS = (
    make_label(1, "zebra", name="pedestrian crossing"),
    make_label(2, "bridge", name="footbridge", aliases=("for pedestrians", "Fußgängerbrücke")),
    make_label(3, "speed-5", name="speed limit 5 km/h"),
    make_label(4, "speed-50", name="speed limit 50 km/h", hidden=True),
    make_label(5, "crosswalk", name="old crosswalk", merged_into=1),
)


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("pedestrian", [1, 2]),
        ("PEDESTRIANS", [2]),
        ("crossing, ped", [1]),
        ("zeb", [1]),
        ("crosswalk", [1]),
        ("fussg", [2]),
        ("speed limit 5", [3]),
        ("limit 50", [4]),
        ("speed", [3, 4]),
        ("footbridge pedestrians", []),
        ("bridge", [2]),
        ("edestrian", []),
        ("-", []),
        ("", []),
    ],
)
def test_labels_are_found_by_words_of_one_of_their_names(text: str, ids: list[int]) -> None:
    assert [label.id for label in LabelFinder(make_set(*PARTS)).with_words(text)] == ids


@pytest.mark.parametrize(
    ("word", "ids"),
    [("pedestriann", [2, 1]), ("limit", [3, 4]), ("walk", [1]), ("brücke", [2]), ("e", []), ("boar", [])],
)
def test_suggestions_resemble_a_word_or_contain_it(word: str, ids: list[int]) -> None:
    assert [label.id for label in LabelFinder(make_set(*PARTS)).suggestions(word).labels] == ids


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("{", "it is not JSON"),
        ('{"key": "a", "key": "b"}', "an object has 'key' twice"),
        ("[]", "not a label set"),
        (json.dumps({"schema": 2, "key": "a", "name": "a"}), "Update tsr"),
        (json.dumps({"key": "a", "name": "a", "colour": 1}), "colour"),
        (
            json.dumps({"key": "a", "name": "a", "next_id": 1, "labels": [{"id": "0", "key": "a", "name": "a"}]}),
            "labels.0.id",
        ),
    ],
)
def test_other_files_are_refused(text: str, reported: str) -> None:
    with pytest.raises(InputError, match=reported):
        parse_set(text, "mine.json")


def test_the_schema_in_the_docs_is_up_to_date() -> None:
    """Regenerate it with ``python -m tsr_engine.labels.schema > docs/label-set.schema.json``."""
    text = (Path(__file__).parents[2] / "docs" / "label-set.schema.json").read_text(encoding="utf-8")
    assert text == schema_text()
    valid = jsonschema_rs.Draft202012Validator(json.loads(text))
    for key in SHIPPED:
        assert valid.is_valid(json.loads(dump_set(shipped_set(key))))
    assert not valid.is_valid({"schema": 1, "key": "a", "name": "a", "labels": [{"id": "0", "key": "a", "name": "a"}]})


@pytest.mark.parametrize("key", SHIPPED)
def test_mirroring_twice_gives_the_same_sign(key: str) -> None:
    images = shipped_set(key).mirror_images()
    assert len(images) >= 18
    assert all(images[images[label]] == label for label in images)


def test_training_mirrors_crops_by_the_label_set() -> None:
    symmetric = (11, 12, 13, 15, 17, 18, 22, 26, 30, 35)
    pairs = ((19, 20), (33, 34), (36, 37), (38, 39))
    expected = {**{c: c for c in symmetric}, **dict(pairs), **{b: a for a, b in pairs}}
    assert shipped_set(DEFAULT).mirror_images() == expected
