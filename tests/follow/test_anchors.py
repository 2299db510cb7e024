"""Anchors that cannot be followed are refused in one sentence before the first proposal."""

from __future__ import annotations

import numpy as np
import pytest

from tests.follow.synthetic_drives import HEIGHT, WIDTH, make_drive
from tests.follow.test_follow import PARTS
from tsr_engine.errors import UsageError
from tsr_engine.follow import Anchor, follow
from tsr_engine.follow.anchors import extend_to_square, place_anchors, templates_of
from tsr_engine.protocols import PixelSource, ScoredBox
from tsr_engine.records import FloatArray

MADE = make_drive(frames=6)


@pytest.mark.parametrize(
    ("frame", "box", "said"),
    [
        (2, [500.0, 10.0, 560.0, 60.0], "outside the picture of 480x320"),
        (2, [-60.0, -60.0, -5.0, -5.0], "outside the picture"),
        (2, [100.0, 100.0, 101.0, 101.0], "too small"),
        (2, [477.0, 100.0, 520.0, 140.0], "too small"),
        (2, [100.0, 100.0, np.nan, 140.0], "finite"),
        (2, [100.0, 100.0, np.inf, 140.0], "finite"),
        (2, [100.0, 100.0, 140.0], "four"),
        (2, [140.0, 100.0, 100.0, 140.0], "x1 < x2"),
        (6, [100.0, 100.0, 140.0, 140.0], "no frame 6"),
        (-1, [100.0, 100.0, 140.0, 140.0], "no frame -1"),
    ],
)
def test_an_invalid_box(frame: int, box: list[float], said: str) -> None:
    events = follow(MADE.source(), [Anchor(frame, np.array(box))], PARTS)
    with pytest.raises(UsageError, match=said) as error:
        next(events)
    assert "\n" not in str(error.value)


def test_two_boxes_of_one_frame() -> None:
    twice = [Anchor(2, MADE.boxes[2]), Anchor(2, MADE.boxes[2])]
    with pytest.raises(UsageError, match="Frame 2 has two boxes"):
        next(follow(MADE.source(), twice, PARTS))


def test_no_box() -> None:
    with pytest.raises(UsageError, match="at least one"):
        next(follow(MADE.source(), [], PARTS))


def test_a_damaged_frame() -> None:
    with pytest.raises(UsageError, match="Frame 3 is damaged"):
        next(follow(MADE.source(corrupt=[3]), [Anchor(3, MADE.boxes[3])], PARTS))


def test_a_black_picture() -> None:
    made = make_drive(frames=6)
    made.pictures[3] = np.zeros_like(made.pictures[3])
    with pytest.raises(UsageError, match="one colour"):
        next(follow(made.source(), [Anchor(3, made.boxes[3])], PARTS))


@pytest.mark.parametrize("frame", [1, 5])
def test_an_anchor_outside_the_allowed_range(frame: int) -> None:
    with pytest.raises(UsageError, match="outside frames 2 to 4"):
        next(follow(MADE.source(), [Anchor(frame, MADE.boxes[frame])], PARTS, first=2, last=4))


@pytest.mark.parametrize(
    ("box", "whole"),
    [
        ([0.0, 50.0, 20.0, 90.0], [-20.0, 50.0, 20.0, 90.0]),
        ([WIDTH - 20.0, 50.0, WIDTH, 90.0], [WIDTH - 20.0, 50.0, WIDTH + 20.0, 90.0]),
        ([50.0, 0.0, 90.0, 30.0], [50.0, -10.0, 90.0, 30.0]),
        ([50.0, HEIGHT - 30.0, 90.0, HEIGHT], [50.0, HEIGHT - 30.0, 90.0, HEIGHT + 10.0]),
        ([0.0, 50.0, 80.0, 90.0], [0.0, 50.0, 80.0, 90.0]),
        ([0.0, 50.0, 19.0, 90.0], [0.0, 50.0, 19.0, 90.0]),
        ([50.0, 0.0, 140.0, 44.0], [50.0, 0.0, 140.0, 44.0]),
        ([40.0, 50.0, 60.0, 90.0], [40.0, 50.0, 60.0, 90.0]),
    ],
)
def test_a_box_cut_by_the_edge_is_extended(box: list[float], whole: list[float]) -> None:
    assert extend_to_square(np.array(box), WIDTH, HEIGHT).tolist() == whole


def test_only_known_signs_are_extended_beyond_the_edge() -> None:
    def look(_: PixelSource, box: FloatArray) -> ScoredBox:
        return ScoredBox(box, 3.0)

    cut = [Anchor(2, np.array([0.0, 50.0, 28.0, 90.0]))]
    said = [Anchor(2, np.array([-10.0, 50.0, 28.0, 90.0]))]
    inside = [Anchor(2, np.array([20.0, 50.0, 48.0, 90.0]))]
    assert place_anchors(MADE.source(), cut, look)[0].box.tolist() == [-12.0, 50.0, 28.0, 90.0]
    assert place_anchors(MADE.source(), cut, None)[0].box.tolist() == [-4.0, 50.0, 28.0, 90.0]
    assert place_anchors(MADE.source(), cut, None)[0].visible_box.tolist() == [0.0, 50.0, 28.0, 90.0]
    assert place_anchors(MADE.source(), said, None)[0].box.tolist() == [-10.0, 50.0, 28.0, 90.0]
    assert place_anchors(MADE.source(), inside, look)[0].box.tolist() == [20.0, 50.0, 48.0, 90.0]


def test_templates_of_a_part_are_not_matched_against_the_whole() -> None:
    sizes = {0: [1.0, 1.0], 2: [1.05, 0.95], 4: [0.7, 1.0]}
    drawn = [
        Anchor(k, np.append(MADE.boxes[k][:2], MADE.boxes[k][:2] + (MADE.boxes[k][2:] - MADE.boxes[k][:2]) * size))
        for k, size in sizes.items()
    ]
    whole, again, part = place_anchors(MADE.source(), drawn, None)
    assert templates_of(whole, [whole, again, part]) == [whole.template, again.template]
    assert templates_of(part, [whole, again, part]) == [part.template]
