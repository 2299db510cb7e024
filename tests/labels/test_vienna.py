"""The shipped set of the Vienna Convention: a superset of the 43 with drawings, generated from its table."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tsr_engine.labels import make_vienna as making
from tsr_engine.labels.files import dump_set, shipped_set
from tsr_engine.labels.make_vienna import TARGET, make_vienna
from tsr_engine.labels.matching import LabelFinder
from tsr_engine.labels.model import Label
from tsr_engine.labels.name_matching import comparable
from tsr_engine.pictograms import draw, names

VIENNA = shipped_set("vienna")
BOTH = [*shipped_set("gtsrb-43"), *VIENNA.labels[43:]]


def test_the_file_is_up_to_date() -> None:
    assert TARGET.read_text(encoding="utf-8") == dump_set(make_vienna())
    assert make_vienna() == VIENNA


def test_it_extends_the_43() -> None:
    for old, new in zip(shipped_set("gtsrb-43"), VIENNA, strict=False):
        assert set(old.aliases) <= set(new.aliases)
        same = {"aliases": (), "mirror": None, "attributes": ()}
        assert new.model_copy(update=same) == old.model_copy(update=same)
        assert old.mirror in (None, new.mirror)
    assert [label.id for label in VIENNA] == list(range(len(VIENNA)))
    assert VIENNA.next_id == len(VIENNA) >= 180 + 43


def test_signs_of_road_works_can_be_marked() -> None:
    temporary = {label.key for label in VIENNA if [one.name for one in label.attributes] == ["temporary"]}
    assert {"speed-limit-50", "no-stopping", "road-works"} <= temporary
    assert temporary == {label.key for label in VIENNA if label.attributes}
    assert "bus-stop" not in temporary


def test_every_name_of_the_43_finds_the_same_label() -> None:
    """A library that switches between the sets reads files as before."""
    old, new = LabelFinder(shipped_set("gtsrb-43")), LabelFinder(VIENNA)
    for label in shipped_set("gtsrb-43"):
        words = [*label.words, str(label.id), f"class {label.id}"]
        if not label.short.isdigit():  # bare numbers are ids
            words.append(label.short)
        for word in words:
            before, after = old.find(word), new.find(word)
            assert before is not None
            assert after is not None
            assert after.label.id == before.label.id, word


def test_no_short_name_is_the_name_of_another() -> None:
    words = {comparable(word): label.key for label in VIENNA for word in label.words}
    shorts = {comparable(label.short): label.key for label in VIENNA}
    assert len(shorts) == len(VIENNA)
    assert not {short: key for short, key in shorts.items() if words.get(short, key) != key}


def test_ids_never_change() -> None:
    """Stored edits hold these numbers: new labels go to the end of the table, and no row moves."""
    given_out = {43: "double-curve-first-to-the-right", 56: "pedestrian-crossing-ahead", 317: "weight-panel"}
    for number, key in given_out.items():
        label = VIENNA.get(number)
        assert label is not None
        assert label.key == key


@pytest.mark.parametrize("label", BOTH, ids=lambda label: label.key)
def test_the_silhouette_is_of_the_shape(label: Label) -> None:
    assert label.pictogram in names()
    alpha = draw(label.pictogram, 96)[..., 3] / 255
    rows, columns = np.flatnonzero(alpha.max(1) > 0.5), np.flatnonzero(alpha.max(0) > 0.5)
    box = alpha[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    upper, lower = (float(half.mean()) for half in np.array_split(box, 2))
    drawn = {
        "triangle": 0.25 < upper < 0.4 and 0.7 < lower < 0.85,
        "inverted triangle": 0.7 < upper < 0.85 and 0.25 < lower < 0.4,
        "circle": abs(box.mean() - np.pi / 4) < 0.02,
        "octagon": abs(box.mean() - 0.83) < 0.02,
        "diamond": abs(box.mean() - 0.52) < 0.03 and abs(upper - lower) < 0.05,
        "rectangle": box.mean() > 0.89,
        "other": box.mean() < 0.6,
    }
    assert drawn[label.shape], (label.shape, box.mean(), upper, lower)


def test_every_drawing_has_a_label() -> None:
    assert {label.pictogram for label in BOTH} == set(names())


def test_mirrors_are_mutual_and_drawn_so() -> None:
    for label in BOTH[43:]:
        if label.mirror is None:
            continue
        other = VIENNA.by_key(label.mirror)
        assert other is not None, label.key
        assert other.mirror == label.key, label.key
        if other.key == label.key:
            continue
        seen = draw(label.pictogram, 64).astype(int)[:, ::-1]
        assert np.abs(seen - draw(other.pictogram, 64)).mean() < 1.0, label.key
    left, right = VIENNA.by_key("road-narrows-on-the-left"), VIENNA.get(24)
    assert left is not None
    assert right is not None
    assert (left.mirror, right.mirror) == (right.key, left.key)


def test_facts_have_their_form() -> None:
    for label in VIENNA:
        assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", label.key)
        assert 0 < len(label.short) <= 12
        assert label.category != "other" or label.key.startswith("end-of-"), label.key
        for alias in label.aliases:
            assert re.match(r"^[A-H], ?\d", alias) is None or re.fullmatch(r"[A-H], \d+[a-z]{0,2}( \(\d+\))?", alias), (
                alias
            )
            assert not alias.startswith("DE ") or re.fullmatch(r"DE \d{3,4}(\.\d)?(-\d+)?", alias), alias


WORDS = {
    "pedestrian-crossing": ["pedestrian_crossing", "crosswalk", "E, 12a", "E12a"],
    "give-way": ["yield"],
    "no-stopping": ["No Stopping", "II-34", "DE 283", "megállni tilos"],
    "no-parking": ["Parkverbot", "várakozni tilos", "prepovedano parkiranje"],
    "bus-stop": ["bus_stop"],
    "speed-limit-40": ["speed limit 40"],
    "speed-limit-110": ["maximum-speed-limit-110"],
    "curve-to-the-left": ["A, 1a"],
    "curve-to-the-right": ["I-1.1"],
    "slippery-road": ["I-11"],
    "no-lorries-over-7-5-t": ["no trucks over 7.5 t", "no trucks over 7,5t"],
    "one-way": ["one way"],
}


@pytest.mark.parametrize(("word", "key"), [(word, key) for key, words in WORDS.items() for word in words])
def test_words_of_data_sets_are_found(word: str, key: str) -> None:
    found = LabelFinder(VIENNA).find(word)
    assert found is not None
    assert found.label.key == key


def test_numbers_in_words_are_kept_apart() -> None:
    finder = LabelFinder(VIENNA)
    assert finder.find("no trucks over 75 t") is None
    assert finder.find("I-1 1") == finder.find("i_1.1") != finder.find("I-11")


@pytest.mark.parametrize(
    ("change", "reported"),
    [
        (("\n44,", "\n45,"), "44 is next"),
        (("\n14,stop,", "\n14,halt,"), "must be 'stop'"),
        (("DE 283;", "DE 286;"), "names two labels"),
        ((",rectangle,", ",square,"), "shape"),
    ],
)
def test_a_row_that_breaks_a_rule_is_refused(
    change: tuple[str, str], reported: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (TARGET.with_suffix(".csv")).read_text(encoding="utf-8")
    assert change[0] in text
    (tmp_path / "vienna.csv").write_text(text.replace(*change), encoding="utf-8")
    monkeypatch.setattr(making, "SETS", tmp_path)
    with pytest.raises(ValueError, match=reported):
        make_vienna()
