"""Ids as pandas writes them."""

from __future__ import annotations

import pytest

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.ids import id_of, real_of, track_of, whole_of


@pytest.mark.parametrize("value", [11, 11.0, "11", "11.0", "11.00"])
def test_one_number_in_many_notations(value: object) -> None:
    assert id_of(value) == whole_of(value, "id", "a.json", "row 1") == track_of(value, "id", "a.json", "row 1") == 11


@pytest.mark.parametrize(
    ("value", "key"), [("0011", "0011"), ("a", "a"), ("11.5", "11.5"), ("-3", -3), (0, 0), ("0", 0)]
)
def test_names_are_unchanged(value: object, key: object) -> None:
    assert id_of(value) == key


@pytest.mark.parametrize("value", [11.5, True, None, [1], 1e400])
def test_invalid_ids(value: object) -> None:
    assert id_of(value) is None
    with pytest.raises(ImportFormatError, match=r"a.json, row 1: image_id must be a whole number. Got"):
        whole_of(value, "image_id", "a.json", "row 1")


@pytest.mark.parametrize("value", [None, "", "nan", "NaN", "None", -1, "-1", -1.0])
def test_values_for_no_track(value: object) -> None:
    assert track_of(value, "track_id", "a.json", "row 1") is None


def test_numbers_in_text_need_permission() -> None:
    assert real_of("45.5", "rotation", "a.json", "row 1", in_text=True) == 45.5
    for value, loose in (("45.5", False), ("north", True), (True, True)):
        with pytest.raises(ImportFormatError, match="row 1: rotation must be a finite number"):
            real_of(value, "rotation", "a.json", "row 1", in_text=loose)
    with pytest.raises(ImportFormatError, match="row 1: rotation is too large"):
        real_of(10**400, "rotation", "a.json", "row 1")
