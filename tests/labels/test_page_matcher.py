"""The page has its own matcher; ``words.json`` has answers that both must give."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import LabelSet
from tsr_engine.labels.name_matching import comparable

CASES = json.loads((Path(__file__).parent / "words.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def finder() -> LabelFinder:
    head = {"schema": 1, "key": "cases", "name": "Cases", "next_id": 49}
    return LabelFinder(LabelSet.model_validate_json(json.dumps({**head, "labels": CASES["labels"]})))


@pytest.mark.parametrize(("name", "answer"), CASES["comparable"])
def test_names_are_normalised_like_on_the_page(name: str, answer: str) -> None:
    assert comparable(name) == answer


@pytest.mark.parametrize(("word", "answer"), CASES["find"])
def test_words_find_the_same_label_as_on_the_page(finder: LabelFinder, word: str, answer: list[object] | None) -> None:
    found = finder.find(word)
    assert (found and [found.label.id, found.how]) == answer
