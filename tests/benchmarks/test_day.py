"""Runs with planted faults for a simulated annotator, and the report on the annotator's work."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.experiment import Result
from benchmarks.experiments.day import EXPERIMENT
from benchmarks.review.faulty_runs import KINDS, ROUNDS, make_faulty_run
from benchmarks.review.simulated_annotator import steps_of
from tsr_engine.track_table import TrackTable

SIZE = (640, 360)
FRAMES = 80


def truth() -> TrackTable:
    """Two signs that grow, and one of no label."""
    frame = np.tile(np.arange(5, 45), 3)
    track = np.repeat([1, 2, 3], 40)
    side = np.tile(np.linspace(16, 60, 40), 3)
    left, top = np.repeat([100.0, 300.0, 480.0], 40), np.full(120, 100.0)
    boxes = np.stack([left, top, left + side, top + side], axis=1)
    label = np.repeat([14, 17, -1], 40)
    return TrackTable(frame, track, boxes, label)


def rows(content: bytes) -> dict[int, dict[int, list[float]]]:
    """Track -> frame -> box and label of a table."""
    found: dict[int, dict[int, list[float]]] = {}
    for line in content.decode().splitlines()[1:]:
        frame, track, *values = line.split(",")
        found.setdefault(int(track), {})[int(frame)] = [float(v) for v in values[:5]]
    return found


def test_each_kind_of_fault_is_planted_once_for_two_signs() -> None:
    seen = []
    for turn in range(ROUNDS):
        content, cases = make_faulty_run(truth(), SIZE, FRAMES, turn, seed=0)
        table = rows(content)
        assert set(table) == {number for number in cases if number > 0}
        for number, case in cases.items():
            if case.label >= 0:
                seen.append(case.kind)
            if number < 0 or case.kind == "false":
                continue
            own = table[number]
            wrong = [f for f in case.truth if not np.allclose(own[f][:4], case.truth[f], atol=0.01)]
            assert wrong == ([case.box_frame] if "box" in case.faults else [])
            assert (max(own) > case.last) == ("end" in case.faults)
            assert ({row[4] for row in own.values()} == {case.label}) == ("label" not in case.faults)
        assert sum(case.kind == "false" for case in cases.values()) == 1
        assert [case.kind for case in cases.values() if case.label == -1 and case.truth] == ["right"]
    assert sorted(seen) == sorted(KINDS)


def test_a_wrong_box_is_planted_on_the_largest_whole_sign() -> None:
    given = truth()
    boxes = given.boxes.copy()
    boxes[given.frame > 40, 0] -= 200  # the first sign is cut by the left edge there
    boxes[:, 0] = np.maximum(boxes[:, 0], 0)
    given = replace(given, boxes=boxes)
    _, cases = make_faulty_run(given, SIZE, FRAMES, 0, seed=0)
    first = next(case for case in cases.values() if case.label == 14)
    assert first.box_frame == 40


@pytest.mark.parametrize(("way", "steps"), [(0, (0, 0)), (1, (0, 1)), (-9, (-1, 1)), (12, (1, 2)), (-20, (-2, 0))])
def test_frames_are_reached_with_few_presses(way: int, steps: tuple[int, int]) -> None:
    assert steps_of(way) == steps


def test_the_report_says_which_bars_are_met() -> None:
    kinds = {
        kind: {"tracks": 3, "actions": actions, "seconds": 0.5, "example": ["a"]}
        for kind, actions in zip((*KINDS, "false"), (1.2, 3.0, 2.0, 2.0, 4.5, 7.0, 1.0), strict=True)
    }
    day = {
        "kinds": kinds,
        "tracks": 21,
        "actions": 2.9,
        "left": dict.fromkeys(("precision", "recall", "signs_classified"), 1.0),
    }
    text = EXPERIMENT.report(Result("day", figures={"now": day, "before": day}))
    assert "| right | 3 | 1.20 | 1.20 | 0.50 | 0.50 | 1.5 actions, met |" in text
    assert "4 actions, missed" in text
    assert "*before*: 2.90" in text
