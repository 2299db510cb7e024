from collections import Counter

import pytest

from tsr_engine.recognition.gtsrb_classes import CLASSES_AFTER_HALF_TURN, SIGN_CLASSES, class_name


def test_the_43_classes_are_at_their_index() -> None:
    assert [c.id for c in SIGN_CLASSES] == list(range(43))
    assert len({c.name for c in SIGN_CLASSES}) == len({c.short for c in SIGN_CLASSES}) == 43
    assert all(len(c.short) <= 12 for c in SIGN_CLASSES)


def test_categories_are_those_of_the_gtsdb_competition() -> None:
    ids = {name: [c.id for c in SIGN_CLASSES if c.category == name] for name in ("prohibitory", "mandatory", "danger")}
    assert ids["prohibitory"] == [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 15, 16]
    assert ids["mandatory"] == list(range(33, 41))
    assert ids["danger"] == [11, *range(18, 32)]
    assert Counter(c.shape for c in SIGN_CLASSES) == {
        "circle": 25, "triangle": 15, "diamond": 1, "inverted triangle": 1, "octagon": 1,
    }  # fmt: skip


@pytest.mark.parametrize(("class_id", "name"), [(14, "stop"), (13, "give way"), (33, "turn right ahead")])
def test_classes_have_names(class_id: int, name: str) -> None:
    assert class_name(class_id) == name


@pytest.mark.parametrize("class_id", [-1, 43])
def test_an_unknown_class_is_refused(class_id: int) -> None:
    with pytest.raises(ValueError, match=r"0\.\.42"):
        class_name(class_id)


def test_turning_twice_is_the_same_class() -> None:
    table = dict(CLASSES_AFTER_HALF_TURN)
    assert all(table[table[c]] == c for c in table)
