"""Names of other tools matched to classes."""

from __future__ import annotations

import pytest

from tests.exchange.exchange_toys import GTSRB, a_dataset, a_set, target_of
from tsr_engine.errors import UsageError
from tsr_engine.exchange.checks import ImportValidator
from tsr_engine.exchange.labels import UNKNOWN, LabelMatcher, label_name


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
        ("14", 14),
        ("00014", 14),
        ("class 14", 14),
        ("class_00014", 14),
        ("20", 20),
        (UNKNOWN, -1),
        ("43", None),
        ("-1", None),
        ("stopp", None),
        ("", None),
        ("99999999999999999999", None),
    ],
)
def test_names(name: str, label: int | None) -> None:
    assert LabelMatcher(GTSRB)(name) == label


def test_what_a_person_said_wins() -> None:
    matcher = LabelMatcher(GTSRB, {"stop": 13, "pole": -1})
    assert (matcher("stop"), matcher("pole"), matcher("Stop")) == (13, -1, 14)


@pytest.mark.parametrize("label", [-2, 43])
def test_a_person_names_a_class_that_does_not_exist(label: int) -> None:
    with pytest.raises(UsageError, match="0 to 42"):
        LabelMatcher(GTSRB, {"x": label})


def test_a_person_names_labels_by_key_too() -> None:
    matcher = LabelMatcher(GTSRB, {"Stopschild": "stop", "Vorfahrt gewähren": "GIVE-WAY"})
    assert (matcher("Stopschild"), matcher("Vorfahrt gewähren")) == (14, 13)
    with pytest.raises(UsageError, match=r"key of no label of .*Did you mean 'give-way'"):
        LabelMatcher(GTSRB, {"x": "give-wey"})


def test_a_label_that_was_merged_stands_for_the_other() -> None:
    labels = a_set("stop", "halt")
    merged = labels.labels[1].model_copy(update={"merged_into": 0})
    matcher = LabelMatcher(labels.model_copy(update={"labels": (labels.labels[0], merged)}), {"x": 1})
    assert (matcher("halt"), matcher("x"), matcher("1")) == (0, 0, 0)


def test_every_class_finds_itself() -> None:
    matcher = LabelMatcher(GTSRB)
    assert [matcher(label_name(GTSRB, k)) for k in range(-1, 43)] == list(range(-1, 43))


@pytest.mark.parametrize(
    ("name", "number", "reported"), [("14", False, 1), ("class 14", False, 1), ("14", True, 0), ("stop", False, 0)]
)
def test_names_that_are_numbers_are_told(name: str, number: bool, reported: int) -> None:
    validator = ImportValidator(target_of(a_dataset()))
    assert validator.label(name, "a.xml", 3, number=number) == 14
    repaired = validator.finish("a.xml").repaired
    assert len(repaired) == reported
    assert all("Label names that are numbers were taken as the tool's label numbers: 1" in each for each in repaired)


def test_numbers_that_a_person_has_named_are_not_told() -> None:
    validator = ImportValidator(target_of(a_dataset(), label_map={"14": 3}))
    assert validator.label("14", "a.xml", 3) == 3
    assert validator.finish("a.xml").repaired == ()
