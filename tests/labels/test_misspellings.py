"""Misspelled names of labels are recognised, and words of something else are not."""

from __future__ import annotations

import pytest

from tsr_engine.labels.files import shipped_set
from tsr_engine.labels.matching import LabelFinder

FINDERS = {key: LabelFinder(shipped_set(key)) for key in ("gtsrb-43", "vienna")}


@pytest.mark.parametrize("labels", FINDERS)
@pytest.mark.parametrize(
    ("word", "key"),
    [
        ("sotp", "stop"),
        ("stopp", "stop"),
        ("yeild", "give-way"),
        ("no entery", "no-entry"),
        ("childern", "children"),
        ("pedestrain", "pedestrians"),
        ("roundabaut", "roundabout"),
        ("slipery road", "slippery-road"),
        ("prioritiy road", "priority-road"),
        ("wild animels", "wild-animals"),
        ("trafic lights", "traffic-lights-ahead"),
        ("no overtakeing", "no-overtaking"),
        ("keep rigth", "keep-right"),
        ("bycicle crossing", "cyclists-crossing"),
        ("speed limt 50", "speed-limit-50"),
        ("generel danger", "general-danger"),
    ],
)
def test_a_misspelled_name_is_recognised(labels: str, word: str, key: str) -> None:
    assert FINDERS[labels].find(word) is None
    assert FINDERS[labels].similar(word)[0].key == key


@pytest.mark.parametrize("labels", FINDERS)
@pytest.mark.parametrize(
    "word",
    ["unicorn", "boar", "building", "elephant", "billboard", "advert", "pole", "house", "person", "background", "tree"],
)
def test_another_word_resembles_no_label(labels: str, word: str) -> None:
    assert FINDERS[labels].similar(word) == []
