"""One board drawn once is followed in both directions, and the follower stops where it ends."""

from __future__ import annotations

import numpy as np
import pytest

from tests.follow import synthetic_drives
from tests.follow.synthetic_drives import Drive, cover_box, make_drive
from tsr_engine.follow import Anchor, Ending, FollowerModels, Proposal, follow, sign_follower
from tsr_engine.follow.search import Match
from tsr_engine.follow.template import Template
from tsr_engine.geometry.boxes import clip, iou_each
from tsr_engine.params import Params
from tsr_engine.pipeline import load_online

PARTS = FollowerModels(load_online(Params()))
"""Without the offline detector, which knows none of these boards."""


def run(made: Drive, *frames: int, **options: object) -> tuple[dict[int, Proposal], dict[str, Ending]]:
    """The final proposals."""
    anchors = [Anchor(k, made.boxes[k]) for k in frames]
    kept: dict[int, Proposal] = {}
    endings: dict[str, Ending] = {}
    for event in follow(made.source(), anchors, PARTS, **options):  # type: ignore[arg-type]
        if isinstance(event, Ending):
            assert event.direction not in endings
            endings[event.direction] = event
            ahead = event.direction == "forward"
            kept = {k: p for k, p in kept.items() if (k <= event.frame if ahead else k >= event.frame)}
        else:
            assert event.frame not in frames or event.source == "anchor"
            kept[event.frame] = event
    return kept, endings


def overlap(made: Drive, kept: dict[int, Proposal], frame: int) -> float:
    return float(iou_each(kept[frame].box, clip(made.boxes[frame], synthetic_drives.WIDTH, synthetic_drives.HEIGHT))[0])


@pytest.mark.parametrize("anchor", [3, 20, 36])
def test_both_directions_from_any_frame(anchor: int) -> None:
    made = make_drive()
    kept, endings = run(made, anchor)
    assert sorted(kept) == list(range(40))
    assert min(overlap(made, kept, k) for k in kept) > 0.8
    assert {d: (e.frame, e.reason) for d, e in endings.items()} == {"forward": (39, "video"), "backward": (0, "video")}
    assert kept[anchor].confidence == 1.0
    assert np.mean([p.confidence for p in kept.values()]) > 0.85
    assert {p.source for k, p in kept.items() if k != anchor} == {"matched"}


def test_fading_light_and_a_shaking_camera() -> None:
    made = make_drive(
        gain=lambda k: 1.0 - 0.6 * np.exp(-(((k - 20) / 5) ** 2)),
        shift=lambda k: (6.0 * np.sin(2.1 * k), 8.0 * np.sin(1.3 * k)),
    )
    kept, _ = run(made, 10)
    assert sorted(kept) == list(range(40))
    assert min(overlap(made, kept, k) for k in kept) > 0.7


def test_a_temporarily_hidden_sign_is_found_again() -> None:
    made = make_drive()
    for k in range(18, 24):
        made.pictures[k] = cover_box(made.pictures[k], made.boxes[k])
    kept, endings = run(made, 10)
    assert endings["forward"].frame == 39
    assert {kept[k].source for k in range(19, 23)} == {"predicted"}
    assert kept[20].confidence < 0.5 < kept[30].confidence
    assert min(overlap(made, kept, k) for k in kept) > 0.6


def test_following_ends_where_the_sign_was_last_seen() -> None:
    made = make_drive(frames=60)
    for k in range(25, 60):
        made.pictures[k] = cover_box(made.pictures[k], made.boxes[k])
    kept, endings = run(made, 10)
    assert endings["forward"].reason == "gone"
    assert 24 <= endings["forward"].frame <= 25
    assert max(kept) == endings["forward"].frame
    assert f"frame {endings['forward'].frame}" in endings["forward"].sentence


def test_following_stops_before_the_sign_is_too_narrow() -> None:
    made = make_drive(first=6.0, last=40.0)
    kept, endings = run(made, 30)
    assert endings["backward"].reason == "small"
    true = min(k for k, box in made.boxes.items() if box[2] - box[0] >= 10.0)
    assert abs(endings["backward"].frame - true) <= 2
    assert "narrower than 10 px" in endings["backward"].sentence
    assert min(kept) == endings["backward"].frame


def test_following_stops_where_the_sign_leaves_the_picture() -> None:
    made = make_drive(first=20.0, last=110.0, at=(60.0, -10.0))
    kept, endings = run(made, 10)
    share = {k: (min(box[2], synthetic_drives.WIDTH) - box[0]) / (box[2] - box[0]) for k, box in made.boxes.items()}
    true = max(k for k, seen in share.items() if seen >= 0.5)
    assert endings["forward"].reason == "picture edge"
    assert abs(endings["forward"].frame - true) <= 1
    assert all((p.box[2:] <= [synthetic_drives.WIDTH, synthetic_drives.HEIGHT]).all() for p in kept.values())


def test_a_wide_board_drawn_at_the_edge_is_followed() -> None:
    made = make_drive(frames=12, first=60.0, last=62.0, at=(0.0, 0.0), shift=lambda k: (0.0, -0.8 * k))
    # its lower part is the board here: it is seen from 5 px below its upper edge on, and could be half of a square
    top = int(made.boxes[0][1]) + 29
    seen = {
        k: np.array([b[0], max(0.6 * b[1] + 0.4 * b[3] - top, 0.0), b[2], b[3] - top]) for k, b in made.boxes.items()
    }
    cut = Drive([np.ascontiguousarray(picture[top:]) for picture in made.pictures], seen)
    kept, endings = run(cut, 0)
    assert (endings["forward"].frame, endings["forward"].reason) == (11, "video")
    assert min(overlap(cut, kept, k) for k in kept) > 0.8


def test_a_scene_cut_ends_following() -> None:
    made, other = make_drive(), make_drive(seed=9)
    pictures = made.pictures[:25] + other.pictures[:15]
    kept, endings = run(Drive(pictures, made.boxes), 20)
    assert (endings["forward"].reason, endings["forward"].frame) == ("cut", 24)
    assert "cut after frame 24" in endings["forward"].sentence
    kept, endings = run(Drive(pictures, made.boxes), 24)
    assert (endings["forward"].reason, max(kept)) == ("cut", 24)


@pytest.mark.parametrize("anchor", [8, 25])
def test_a_frozen_stretch_keeps_the_box_and_continues(anchor: int) -> None:
    made = make_drive()
    still = [*made.pictures[:20], *[made.pictures[19]] * 12, *made.pictures[20:]]
    boxes = {k: made.boxes[k if k < 20 else max(19, k - 12)] for k in range(52)}
    frozen = Drive(still, boxes)
    kept, endings = run(frozen, anchor)
    assert (endings["backward"].frame, endings["forward"].frame) == (0, 51)
    assert min(overlap(frozen, kept, k) for k in kept) > 0.7
    assert all(np.array_equal(kept[k].box, kept[19].box) for k in range(20, 32))


def test_a_short_black_stretch_is_bridged() -> None:
    made = make_drive()
    for k in range(15, 18):
        made.pictures[k] = np.zeros_like(made.pictures[k])
    kept, endings = run(made, 10)
    assert endings["forward"].frame == 39
    assert {kept[k].source for k in (15, 16, 17)} == {"predicted"}
    assert overlap(made, kept, 30) > 0.8


def test_limits_and_one_direction() -> None:
    made = make_drive()
    kept, endings = run(made, 20, direction="backward", first=12)
    assert sorted(kept) == list(range(12, 21))
    assert list(endings) == ["backward"]
    assert (endings["backward"].reason, endings["backward"].frame) == ("limit", 12)
    requests: list[int] = []
    list(follow(made.source(requests), [Anchor(20, made.boxes[20])], PARTS, first=15, last=22))
    assert (min(requests), max(requests)) == (15, 22)


def test_proposals_arrive_one_by_one_from_the_anchor_outwards() -> None:
    made = make_drive()
    requests: list[int] = []
    events = follow(made.source(requests), [Anchor(20, made.boxes[20])], PARTS)
    frames = [next(events).frame for _ in range(7)]
    assert frames == [20, 21, 19, 22, 18, 23, 17]
    assert (min(requests), max(requests)) == (17, 23)


def test_cancelling_ends_following_between_two_frames() -> None:
    made = make_drive()
    given = 0

    def cancelled() -> bool:
        return given >= 6

    ends = []
    for event in follow(made.source(), [Anchor(20, made.boxes[20])], PARTS, cancelled=cancelled):
        given += 1
        if isinstance(event, Ending):
            ends.append(event)
    assert [e.reason for e in ends] == ["cancelled", "cancelled"]
    assert given <= 9


def test_following_continues_through_damaged_frames() -> None:
    made = make_drive()
    source = made.source(corrupt=range(21, 40))
    boxes = [e for e in follow(source, [Anchor(15, made.boxes[15])], PARTS) if isinstance(e, Proposal)]
    assert {e.frame for e in boxes} >= set(range(35))


def test_a_poor_match_is_not_used_as_a_measurement(monkeypatch: pytest.MonkeyPatch) -> None:
    made = make_drive(frames=6)
    picture, box = made.pictures[2], made.boxes[2]
    monkeypatch.setattr(sign_follower, "search", lambda *_: Match(box + 30.0, 1e-4, 0.45, 0.45))
    way = sign_follower.SignFollower(picture, box, [Template.cut(picture, box, 0.0, True)], "forward", FollowerModels())
    step = way.step(picture, (0.0, 0.0))
    assert step.source == "predicted"
    assert iou_each(step.box, box)[0] > 0.9
