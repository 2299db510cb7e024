"""Names of other tools matched to classes."""

from __future__ import annotations

import pytest

from tests.exchange.small_datasets import GTSRB, make_dataset, make_label_set, target_of
from tsr_engine.errors import UsageError
from tsr_engine.exchange.added_labels import UnknownLabels
from tsr_engine.exchange.import_validator import ImportValidator
from tsr_engine.exchange.labels import UNKNOWN, LabelMatcher, label_name
from tsr_engine.labels.files import shipped_set


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("stop", 14),
        ("STOP", 14),
        ("Give_Way", 13),
        ("giveway", 13),
        ("speed limit 30 km/h", 1),
        ("Speed-Limit_30 KM/H", 1),
        ("priority rd", 12),
        ("14", None),
        ("00014", None),
        ("class 14", None),
        ("20", None),
        (UNKNOWN, -1),
        ("43", None),
        ("-1", None),
        ("stopp", None),
        ("", None),
        ("99999999999999999999", None),
    ],
)
def test_names_are_matched(name: str, label: int | None) -> None:
    assert LabelMatcher(GTSRB)(name) == label


def test_a_given_mapping_wins() -> None:
    matcher = LabelMatcher(GTSRB, {"stop": 13, "pole": -1})
    assert (matcher("stop"), matcher("pole"), matcher("Stop")) == (13, -1, 14)


@pytest.mark.parametrize("label", [-2, 43])
def test_mapping_to_an_unknown_class_is_refused(label: int) -> None:
    with pytest.raises(UsageError, match="0 to 42"):
        LabelMatcher(GTSRB, {"x": label})


def test_mapping_accepts_keys() -> None:
    matcher = LabelMatcher(GTSRB, {"Stopschild": "stop", "Vorfahrt gewähren": "GIVE-WAY"})
    assert (matcher("Stopschild"), matcher("Vorfahrt gewähren")) == (14, 13)
    with pytest.raises(UsageError, match=r"key of no label of .*Did you mean 'give-way'"):
        LabelMatcher(GTSRB, {"x": "give-wey"})


def test_merged_labels_are_resolved() -> None:
    labels = make_label_set("stop", "halt")
    merged = labels.labels[1].model_copy(update={"merged_into": 0})
    matcher = LabelMatcher(labels.model_copy(update={"labels": (labels.labels[0], merged)}), {"x": 1})
    assert (matcher("halt"), matcher("x"), matcher.numbered("1")) == (0, 0, 0)


def test_every_class_name_matches_its_class() -> None:
    matcher = LabelMatcher(GTSRB)
    assert [matcher(label_name(GTSRB, k)) for k in range(-1, 43)] == list(range(-1, 43))


@pytest.mark.parametrize("name", ["14", "00014", "class 14", "class_00014", "#14"])
def test_numbers_are_ids_only_in_numeric_fields(name: str) -> None:
    assert LabelMatcher(GTSRB).numbered(name) == 14
    validator = ImportValidator(target_of(make_dataset()))
    assert validator.label(name, "a.xml", 3, number=True) == 14
    validator.box("a", 1, (0, 0, 9, 9), validator.label(name, "a.xml", 3), file="a.xml")
    with pytest.raises(UnknownLabels, match=r"1 track, 1 box; like 'stop'\)\. It stands in a\.xml, line 3\."):
        validator.finish("a.xml")


@pytest.mark.parametrize(
    ("name", "like"),
    [
        ("50", ["speed-limit-50", "end-of-speed-limit-50", "minimum-speed-50"]),
        ("10", ["speed-limit-10", "no-overtaking-by-lorries"]),
        ("14", ["stop"]),
        ("9999", []),
    ],
)
def test_a_number_as_a_name_is_not_matched_by_id(name: str, like: list[str]) -> None:
    """50 is a speed limit in most files, and the id of another sign in `vienna`."""
    vienna = shipped_set("vienna")
    matcher = LabelMatcher(vienna)
    assert matcher(name) is None
    assert [label.key for label in matcher.suggestions(name).labels] == like


def test_a_suggestion_that_only_contains_the_name_is_marked() -> None:
    matcher = LabelMatcher(make_label_set("no bus lane ahead", "stop"))
    assert matcher("bus") is None
    for name, like, similar in (("bus", ["no bus lane ahead"], False), ("stopp", ["stop"], True), ("boar", [], False)):
        found = matcher.suggestions(name)
        assert ([label.name for label in found.labels], found.similar) == (like, similar)


def test_a_label_named_by_a_number_is_matched() -> None:
    fifty = make_label_set("stop", "50", "fifty")
    matcher = LabelMatcher(fifty)
    assert (matcher("50"), matcher.numbered("50"), matcher.numbered("2"), matcher("2")) == (1, 1, 2, None)


def test_mapped_numbers_are_not_reported() -> None:
    validator = ImportValidator(target_of(make_dataset(), label_map={"14": 3}))
    assert validator.label("14", "a.xml", 3) == 3
    assert validator.finish("a.xml").repaired == ()
