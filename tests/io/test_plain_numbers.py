"""Numbers as files write them, not in all of Python's notations."""

from __future__ import annotations

import math

import pytest

from tsr_engine.io.plain_numbers import parse_real, parse_whole


@pytest.mark.parametrize(
    ("text", "value"),
    [("7", 7.0), (" -1.5 ", -1.5), ("+.5", 0.5), ("3.", 3.0), ("1e-3", 0.001), ("inf", math.inf), ("-INF", -math.inf)],
)
def test_valid_numbers_are_read(text: str, value: float) -> None:
    assert parse_real(text) == value


def test_nan_is_left_to_the_caller() -> None:
    assert math.isnan(parse_real("nan"))


@pytest.mark.parametrize(
    "text", ["1_0", "1_0.5", "1e1_0", "\u0661\u0660", "\uff11", "1\u00a0", "\u22121", "", "ten", "0x1p3"]
)
def test_invalid_numbers_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="no number|convert|literal"):
        parse_real(text)
    with pytest.raises(ValueError, match="no number|convert|literal"):
        parse_whole(text)


def test_integers_are_read_or_refused() -> None:
    assert [parse_whole(text) for text in ("7", " -12 ", "+3", "007")] == [7, -12, 3, 7]
    with pytest.raises(ValueError, match="no number|convert|literal"):
        parse_whole("1.0")
