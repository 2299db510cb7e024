"""The figures of following: filled, matched and drifted boxes, and the report."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.experiment import Result
from benchmarks.experiments import follow as experiment
from benchmarks.experiments import follow_approaches, follow_page
from benchmarks.following.figures import MAX_ACTIONS, actions, figures_of, lines_needed, mean_of
from benchmarks.following.methods import (
    PEERS,
    KltBox,
    follow_with_engine,
    follow_with_peer,
    interpolate_linearly,
    peer_maker,
)
from benchmarks.following.visible_signs import POSITIONS, Sign, paint_over, signs_of
from tests.follow.synthetic_drives import HEIGHT, WIDTH, make_drive
from tsr_engine.follow import FollowerModels
from tsr_engine.track_table import TrackTable


def truth(boxes: dict[int, Any], visibility: Any = None) -> TrackTable:
    n = len(boxes)
    seen = np.ones(n) if visibility is None else np.array([visibility(k) for k in boxes])
    return TrackTable(
        np.array(list(boxes)),
        np.ones(n, int),
        np.array(list(boxes.values())),
        np.zeros(n, int),
        visibility=seen,
    )


MADE = make_drive(frames=30, first=8.0, last=48.0)


def sign() -> Sign:
    return signs_of(truth(MADE.boxes), WIDTH, HEIGHT)[0]


def test_the_life_of_a_sign_begins_at_ten_pixels_and_omits_hidden_frames() -> None:
    found = signs_of(truth(MADE.boxes, lambda k: 0.3 if 10 <= k < 14 else 0.6 if k == 20 else 1.0), WIDTH, HEIGHT)[0]
    assert min(found.life) == min(k for k, b in MADE.boxes.items() if b[2] - b[0] >= 10.0) > 0
    assert not {10, 11, 12, 13} & set(found.life)
    assert 20 in found.life
    assert 20 not in found.clear
    assert len(found.rows) == 30
    assert {found.anchor(p) for p in POSITIONS} <= set(found.clear)


def test_signs_that_stay_small_are_not_followed() -> None:
    small = {k: np.array([100.0, 100.0, 113.0, 113.0]) for k in range(20)}
    assert signs_of(truth(small), WIDTH, HEIGHT) == []
    assert signs_of(truth({k: MADE.boxes[k] for k in range(25, 30)}), WIDTH, HEIGHT) == []


def test_figures_of_exact_boxes() -> None:
    assert figures_of(sign(), sign().rows) == {"iou70": 1.0, "iou50": 1.0, "ends_met": 1.0, "runaway": 0.0}


def test_a_box_beyond_the_end_of_its_sign_has_drifted() -> None:
    beyond = {**sign().rows, **{30 + k: MADE.boxes[29] for k in range(4)}}
    assert figures_of(sign(), beyond)["runaway"] == 1.0
    assert figures_of(sign(), beyond)["ends_met"] == 0.0
    assert figures_of(sign(), {k: b for k, b in beyond.items() if k < 33})["runaway"] == 0.0


def test_a_box_elsewhere_has_drifted() -> None:
    away = {k: b + 200.0 if 15 <= k < 19 else b for k, b in sign().rows.items()}
    figures = figures_of(sign(), away)
    assert figures["runaway"] == 1.0
    assert figures["iou50"] == pytest.approx(1 - 4 / len(sign().life))


def test_an_end_that_is_missed() -> None:
    late = {k: b for k, b in sign().rows.items() if k >= min(sign().life) + 4}
    assert figures_of(sign(), late)["ends_met"] == 0.0


def test_interpolation_matches_its_key_boxes() -> None:
    drawn = {k: MADE.boxes[k] for k in (5, 29)}
    lines = interpolate_linearly(drawn)
    assert sorted(lines) == list(range(5, 30))
    assert np.allclose(lines[29], MADE.boxes[29])
    assert np.allclose(lines[17], (MADE.boxes[5] + MADE.boxes[29]) / 2)
    assert 2 < lines_needed(sign()) <= 6


def test_actions_are_counted_until_all_boxes_are_right() -> None:
    def perfect(drawn: Any) -> Any:
        return sign().life

    def only_drawn(drawn: Any) -> Any:
        return drawn

    assert actions(sign(), 20, perfect) == 1
    assert actions(sign(), 20, interpolate_linearly) > 2
    assert actions(sign(), 20, only_drawn) == MAX_ACTIONS


def test_a_painted_over_sign_is_removed_from_pixels_and_rows() -> None:
    pictures, rest = paint_over(MADE.pictures, sign(), 0.5)
    last = max(rest.rows)
    assert last < 29
    assert np.array_equal(pictures[last], MADE.pictures[last])
    x1, y1, x2, y2 = (int(v) for v in MADE.boxes[last + 1])
    there, before = pictures[last + 1][y1:y2, x1:x2], MADE.pictures[last + 1][y1:y2, x1:x2]
    assert np.abs(there.astype(int) - before).mean() > 20


def test_ours_and_a_flow_box_fill_a_life() -> None:
    start = sign().anchor("middle")
    ours = follow_with_engine(MADE.pictures, {start: MADE.boxes[start]}, FollowerModels())
    assert figures_of(sign(), ours.boxes)["iou70"] > 0.9
    assert ours.steps == len(ours.boxes)  # without the drawn one, with one that is too narrow
    assert ours.seconds > 0.0
    klt = follow_with_peer(MADE.pictures, start, MADE.boxes[start], KltBox)
    assert figures_of(sign(), klt.boxes)["iou50"] > 0.3
    assert peer_maker("KLT") is KltBox


def test_the_report_names_the_best_and_the_missing() -> None:
    row = {"iou70": 0.9, "iou50": 1.0, "ends_met": 1.0, "runaway": 0.0}
    worse = {**row, "iou70": 0.4, "runaway": 1.0}
    places = {p: mean_of([row, row]) for p in POSITIONS}
    peer = {p: mean_of([worse, worse]) for p in POSITIONS}
    figures = {
        "groups": {"clips": {"ours": places, "CSRT": peer, "lines, 2 exact boxes": {"whole life": mean_of([worse])}}},
        "actions": {
            "clips": {**dict.fromkeys(POSITIONS, 1.2), "lines": 4.0, "starts": 2},
            "blur": {**dict.fromkeys(POSITIONS, 1.0), "lines": 3.0, "starts": 6},
        },
        "ms": {"ours at 720p": 8.0, "CSRT at 720p": 20.0},
        "memory": {"frames": 10000, "group": 250, "early": 1000, "early_mb": 300.0, "late_mb": 301.0},
        "missing": {"TLD": "no such build."},
    }
    reported = experiment.EXPERIMENT.report(Result("follow", figures=figures))
    assert "**0.900** / 1.000; 1.00; 0.00" in reported
    assert "| CSRT | 0.400 / 1.000; 1.00; 1.00" in reported
    assert "| clips | 1.20 | 1.20 | 1.20 | 4.00 |" in reported
    assert "| all 8 signs | 1.05 | 1.05 | 1.05 | 3.25 |" in reported
    assert "8.0 ms (125 frames/s)" in reported
    assert "TLD is not there: no such build." in reported
    assert set(PEERS) == {"CSRT", "KCF", "MIL", "TLD", "KLT"}


def test_the_report_on_all_approaches_says_where_ours_is_below() -> None:
    ours = {"iou70": 0.9, "iou50": 1.0, "iou": 0.95, "ends_met": 1.0, "runaway": 0.0}
    behind = {**dict.fromkeys(POSITIONS, mean_of([ours])), "middle": mean_of([{**ours, "iou70": 0.8, "runaway": 1.0}])}
    figures = {"all": {"ours": behind, "KLT": dict.fromkeys(POSITIONS, mean_of([ours]))}}
    reported = follow_approaches.EXPERIMENT.report(Result("follow_approaches", figures=figures))
    assert "| all | 1 | KLT | 0.900 / 1.000 / 0.950; 1.00; 0.00 |" in reported
    assert "Ours is below the peer at: all, middle (IoU >= 0.7); all, middle (runaways)." in reported


def test_the_report_on_the_page_says_whether_its_bars_are_met() -> None:
    figures = {
        "late": [{"actions": [",", "Enter"], "share": 1.0}, {"actions": ["j", ",", "Enter"], "share": 0.9}],
        "missed": [{"actions": ["n", "drag", "type the label", "Enter", "a"], "share": 1.0}],
        "first": {"ms": [100.0] * 9 + [400.0], "load": 1.5},
    }
    reported = follow_page.EXPERIMENT.report(Result("follow_page", figures=figures, machine={"cores": 2}))
    assert "| late | 2 | 2.50 | 3 | 3, met | 0.950 | `j` `,` `Enter` |" in reported
    assert "| 4, missed |" in reported
    assert "100 ms (median of 10)" in reported
    assert "bar 200 ms, missed, at a load of 1.5 on 2 cores" in reported
