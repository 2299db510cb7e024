"""The message that refuses a word which is no label."""

from __future__ import annotations

import pytest

from tests.labels.test_label_set import make_label
from tsr_engine.labels.matching import unknown_label
from tsr_engine.labels.model import LabelSet

STOP = make_label(0, "stop")
STREETS = LabelSet(key="streets", name="Streets", next_id=9, labels=(STOP, make_label(1, "bus-stop", name="bus stop")))
RAILS = LabelSet(key="rails", name="Rails", next_id=9, labels=(STOP, make_label(1, "whistle")))


@pytest.mark.parametrize(
    ("word", "sets", "message"),
    [
        ("stopp", (STREETS,), "label set 'Streets' has the key, name, alias or number 'stopp'. Is it 'stop'?"),
        (
            "whistl",
            (STREETS, RAILS),
            "label sets 'Streets', 'Rails' has the key, name, alias or number 'whistl'. Is it",
        ),
        ("stopp", (STREETS, RAILS), "Is it 'stop'?"),
        ("boar", (RAILS,), "'boar'. The page Labels and 'tsr labels list' list the labels."),
    ],
)
def test_the_message_names_word_sets_and_similar_labels(word: str, sets: tuple[LabelSet, ...], message: str) -> None:
    assert message in unknown_label(word, *sets)
