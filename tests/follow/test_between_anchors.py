"""Between two anchors the passes of both directions are joined."""

from __future__ import annotations

import numpy as np
import pytest

from tests.follow.synthetic_drives import cover_box, make_drive
from tests.follow.test_follow import PARTS, overlap, run
from tsr_engine.errors import UsageError
from tsr_engine.follow import Anchor, Ending, follow
from tsr_engine.follow.joined_passes import interpolate, join_passes
from tsr_engine.follow.sign_follower import Step
from tsr_engine.geometry.boxes import iou_each


def step(box: list[float], confidence: float = 0.9, source: str = "matched", error: float = 1.0) -> Step:
    return Step(np.array(box), confidence, source, error, 0.02 * error, None)  # type: ignore[arg-type]


def test_only_frames_between_the_anchors_are_searched() -> None:
    made = make_drive()
    requests: list[int] = []
    anchors = [Anchor(30, made.boxes[30]), Anchor(10, made.boxes[10])]
    events = list(follow(made.source(requests), anchors, PARTS, between=True))
    assert not any(isinstance(event, Ending) for event in events)
    assert (min(requests), max(requests)) == (10, 30)
    kept = {event.frame: event for event in events}
    assert sorted(kept) == list(range(10, 31))
    assert min(overlap(made, kept, k) for k in kept) > 0.85  # type: ignore[arg-type]


def test_a_hidden_stretch_is_filled() -> None:
    made = make_drive(frames=80)
    for k in range(20, 60):
        made.pictures[k] = cover_box(made.pictures[k], made.boxes[k])
    kept, _ = run(made, 10, 70, between=True)
    assert sorted(kept) == list(range(10, 71))
    assert min(overlap(made, kept, k) for k in kept) > 0.6
    assert {kept[k].source for k in range(25, 55)} == {"predicted"}
    assert max(kept[k].confidence for k in range(25, 55)) < 0.5


def test_following_continues_beyond_the_outer_anchors() -> None:
    made = make_drive()
    kept, endings = run(made, 12, 20, 28)
    assert sorted(kept) == list(range(40))
    assert set(endings) == {"forward", "backward"}
    for k in (12, 20, 28):
        assert np.array_equal(kept[k].box, made.boxes[k])


def test_a_single_anchor_has_no_frames_between() -> None:
    made = make_drive(frames=8)
    with pytest.raises(UsageError, match="at least two boxes"):
        next(follow(made.source(), [Anchor(3, made.boxes[3])], PARTS, between=True))


def test_the_joined_box_is_nearer_to_the_more_confident_one() -> None:
    left, right = (0, np.array([0.0, 0.0, 40.0, 40.0])), (2, np.array([4.0, 0.0, 44.0, 40.0]))
    joined = join_passes(left, right, {1: step([0, 0, 40, 40], error=3.0)}, {1: step([4, 0, 44, 40], error=1.0)})
    assert 3.0 < joined[1].box[0] < 4.0
    assert joined[1].confidence > 0.9


def test_of_two_distant_boxes_the_more_confident_one_is_used() -> None:
    left, right = (0, np.array([0.0, 0.0, 40.0, 40.0])), (2, np.array([4.0, 0.0, 44.0, 40.0]))
    joined = join_passes(left, right, {1: step([0, 0, 40, 40], 0.95)}, {1: step([90, 0, 130, 40], 0.7)})
    assert joined[1].box.tolist() == [0, 0, 40, 40]
    assert joined[1].confidence < 0.5


def test_a_frame_beyond_a_cut_is_left_out() -> None:
    left, right = (0, np.array([0.0, 0.0, 40.0, 40.0])), (4, np.array([4.0, 0.0, 44.0, 40.0]))
    joined = join_passes(left, right, {1: step([1, 0, 41, 40])}, {})
    assert sorted(joined) == [1]


def test_an_interpolated_box_looms() -> None:
    made = make_drive(frames=41, first=10.0, last=90.0, at=(30.0, -20.0))
    box = interpolate((0, made.boxes[0]), (40, made.boxes[40]), 25)
    assert iou_each(box, made.boxes[25])[0] > 0.99
