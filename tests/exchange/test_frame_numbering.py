"""The first number of a list of frame numbers."""

from __future__ import annotations

import pytest

from tsr_engine.exchange.frame_numbering import NumberingScheme, find_origin

FROM_0 = NumberingScheme(0, "a tool counts so")
FROM_1 = NumberingScheme(1, "a tool counts so")


def _origin(least: int, largest: int, custom: NumberingScheme | None = None, asked: str = "auto") -> tuple[int, str]:
    found = find_origin(least, largest, 100, requested=asked, scheme=custom, what="numbers", fail=KeyError)
    return found.origin, found.report


@pytest.mark.parametrize(
    ("least", "largest", "custom", "origin", "reported"),
    [
        (0, 50, None, 0, "0 is among them"),
        (0, 50, FROM_1, 0, "0 is among them"),
        (0, 99, None, 0, "0 is among them"),
        (1, 100, None, 1, "from 1 to 100, the number of frames"),
        (1, 100, FROM_0, 1, "from 1 to 100, the number of frames"),
        (1, 100, NumberingScheme(0), 1, "from 1 to 100, the number of frames"),
        (40, 100, None, 1, "frame 100 is among them"),
        (10, 20, FROM_0, 0, "a tool counts so"),
        (10, 20, FROM_1, 1, "a tool counts so"),
        (98, 100, FROM_1, 1, "a tool counts so"),
        (10, 20, NumberingScheme(0), 0, ""),
        (0, 99, NumberingScheme(0), 0, ""),
        # Beyond the video: the caller refuses the numbers.
        (98, 100, FROM_0, 0, ""),
        (0, 100, None, 0, ""),
        (5, 300, None, 0, ""),
    ],
)
def test_the_whole_list_decides(
    least: int, largest: int, custom: NumberingScheme | None, origin: int, reported: str
) -> None:
    found, sentence = _origin(least, largest, custom)
    assert found == origin
    assert reported in sentence
    assert bool(reported) == bool(sentence)
    assert not sentence or "(first_frame)" in sentence


def test_a_given_option_decides() -> None:
    assert _origin(10, 20, FROM_1, "0") == (0, "")
    assert _origin(0, 99, None, "1") == (1, "")


def test_ambiguous_lists_are_not_guessed() -> None:
    with pytest.raises(
        KeyError, match=r"\(10 to 20\) fit a count from 0 and one from 1.*first_frame=0 or first_frame=1"
    ):
        _origin(10, 20)


@pytest.mark.parametrize(
    ("before", "widths", "wrote"),
    [
        ("frame_", {(6, True)}, True),
        ("drive_frame_", {(6, True), (7, False)}, True),
        ("frame_", {(6, False)}, True),
        ("frame_", {(7, True)}, False),
        ("frame_", {(4, True)}, False),
        ("img_", {(6, True)}, False),
    ],
)
def test_possible_names_of_a_tool(before: str, widths: set[tuple[int, bool]], wrote: bool) -> None:
    assert NumberingScheme(0, prefix_pattern=r"(?:.+_)?frame_", digits=6).matches(before, widths) == wrote
