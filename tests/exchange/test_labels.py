"""Names of other tools matched to classes."""

from __future__ import annotations

import pytest
from exchange_toys import a_dataset, target_of

from tsr_engine.errors import UsageError
from tsr_engine.exchange.checks import Intake
from tsr_engine.exchange.labels import CLASS_NAMES, UNKNOWN, LabelMatcher, label_name


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
    assert LabelMatcher(CLASS_NAMES)(name) == label


def test_what_a_person_said_wins() -> None:
    matcher = LabelMatcher(CLASS_NAMES, {"stop": 13, "pole": -1})
    assert (matcher("stop"), matcher("pole"), matcher("Stop")) == (13, -1, 14)


@pytest.mark.parametrize("label", [-2, 43])
def test_a_person_names_a_class_that_does_not_exist(label: int) -> None:
    with pytest.raises(UsageError, match="0 to 42"):
        LabelMatcher(CLASS_NAMES, {"x": label})


def test_the_exact_name_wins_over_a_looser_one() -> None:
    assert LabelMatcher(("Stop", "stop"))("stop") == 1


def test_every_class_finds_itself() -> None:
    matcher = LabelMatcher(CLASS_NAMES)
    assert [matcher(label_name(CLASS_NAMES, k)) for k in range(-1, 43)] == list(range(-1, 43))


@pytest.mark.parametrize(
    ("name", "number", "told"), [("14", False, 1), ("class 14", False, 1), ("14", True, 0), ("stop", False, 0)]
)
def test_names_that_are_numbers_are_told(name: str, number: bool, told: int) -> None:
    intake = Intake(target_of(a_dataset()))
    assert intake.label(name, "a.xml", 3, number=number) == 14
    repaired = intake.finish("a.xml").repaired
    assert len(repaired) == told
    assert all("Class names that are numbers were taken as the tool's class numbers: 1" in each for each in repaired)


def test_numbers_that_a_person_has_named_are_not_told() -> None:
    intake = Intake(target_of(a_dataset(), label_map={"14": 3}))
    assert intake.label("14", "a.xml", 3) == 3
    assert intake.finish("a.xml").repaired == ()
