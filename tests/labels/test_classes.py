"""Class numbers of models as labels of a set."""

from __future__ import annotations

import numpy as np

from tsr_engine.labels.classes import classes_of_keys, classes_of_set, default_keys
from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.model import NO_LABEL, Label, LabelSet
from tsr_engine.recognition.gtsrb_classes import SIGN_CLASSES

GTSRB = shipped_set("gtsrb-43")
CUSTOM_SET = LabelSet(
    key="ours",
    name="Ours",
    next_id=9,
    labels=(
        Label(id=0, key="elsobbsegadas", name="Elsőbbségadás", aliases=("yield",)),
        Label(id=3, key="stop", name="Állj", short="STOP"),
        Label(id=5, key="bus-stop", name="bus stop"),
        Label(id=6, key="all-stop", name="all stop", merged_into=3),
        Label(id=7, key="bin", name="litter bin", teach="background"),
    ),
)


def test_the_classes_of_old_models_are_the_labels_of_gtsrb() -> None:
    classes = classes_of_keys(None, GTSRB)
    numbers = np.arange(-1, 43)
    assert classes.to_labels(numbers).tolist() == numbers.tolist()
    assert [classes.shown(sign.id) for sign in SIGN_CLASSES] == [sign.name for sign in SIGN_CLASSES]
    assert [classes.short(sign.id) for sign in SIGN_CLASSES] == [sign.short for sign in SIGN_CLASSES]
    assert list(classes.numbers()) == list(range(43))
    assert len(default_keys()) == 43
    assert classes.labels_without_class() == []


def test_a_set_of_other_labels() -> None:
    classes = classes_of_keys(None, CUSTOM_SET)
    assert (classes.to_label(14), classes.to_label(13), classes.to_label(12)) == (3, 0, NO_LABEL), "by key, by alias"
    assert classes.to_labels(np.array([14, -1, 12, 13, 99])).tolist() == [3, -1, NO_LABEL, 0, NO_LABEL]
    assert (classes.shown(14), classes.short(14), classes.name(14)) == ("Állj", "STOP", "stop")
    assert (classes.shown(12), classes.is_unmapped(12)) == ("priority road", True)
    assert not classes.is_unmapped(-1)
    assert (classes.to_class(3), classes.to_class(6), classes.to_class(5)) == (14, 14, None)
    assert [label.key for label in classes.labels_without_class()] == ["bus-stop"]


def test_a_model_with_other_labels() -> None:
    classes = classes_of_keys(("bus stop", "all-stop", "14", "STOP"), CUSTOM_SET)
    assert [classes.to_label(number) for number in range(4)] == [5, 3, NO_LABEL, 3]
    assert (classes.name(2), classes.name(4)) == ("14", "class 4"), "a key that is a number is no id"
    assert classes.to_class(3) == 1


def test_ids_of_a_set() -> None:
    classes = classes_of_set("ours", CUSTOM_SET)
    assert classes.to_labels(np.array([0, 3, 6, 4, -1])).tolist() == [0, 3, 3, NO_LABEL, -1]
    assert (classes.shown(6), classes.name(4)) == ("Állj", "label 4 of ours")
