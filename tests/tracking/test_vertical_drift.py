"""The part of the picture's shift that is taken for a rotation of the camera."""

from __future__ import annotations

import numpy as np
import pytest

from tsr_engine.params.tracking import TrackingParams
from tsr_engine.records import Detections
from tsr_engine.tracking.tracker import Tracker
from tsr_engine.tracking.vertical_drift import VerticalDriftFilter


def test_a_lasting_tilt_is_not_a_rotation() -> None:
    level = VerticalDriftFilter(60)
    left = [level.remove_drift((2.0, -3.0)) for _ in range(40)]
    assert left[0] == (2.0, -1.5)
    assert left[-1] == (2.0, pytest.approx(-3.0 / 41))
    assert [dy for _, dy in left] == sorted(dy for _, dy in left)


def test_a_bump_is_a_rotation() -> None:
    level = VerticalDriftFilter(60)
    for _ in range(30):
        level.remove_drift((0.0, 0.01))
    assert level.remove_drift((0.0, 6.0))[1] == pytest.approx(6.0, abs=0.2)
    assert level.remove_drift((0.0, -6.0))[1] == pytest.approx(-6.0, abs=0.2)


def test_shifts_older_than_the_window_are_forgotten() -> None:
    level = VerticalDriftFilter(4)
    for _ in range(10):
        level.remove_drift((0.0, 5.0))
    left = [level.remove_drift((1.0, 10.0))[1] for _ in range(5)]
    assert left == [pytest.approx(10.0 - (5.0 * n + 10.0 * (4 - n)) / 5) for n in (3, 2, 1, 0, 0)]


def test_a_stopping_car_causes_no_rotation() -> None:
    level = VerticalDriftFilter(60)
    for _ in range(60):
        level.remove_drift((0.0, -3.0))
    assert level.remove_drift((0.0, -0.01)) == (0.0, 0.0)
    assert level.remove_drift((0.0, 0.01)) == (0.0, 0.01)


def test_a_time_gap_counts_as_several_shifts() -> None:
    level = VerticalDriftFilter(60)
    for _ in range(60):
        level.remove_drift((0.0, -3.0))
    assert level.remove_drift((0.0, -15.0), dt=5.0)[1] == pytest.approx(-15.0 * (1 - 60 / 61))
    assert level.remove_drift((0.0, -3.0))[1] == pytest.approx(-3.0 * (1 - 60 / 61))


def test_a_repeated_time_stamp_has_no_extra_weight() -> None:
    """The time step is then at its minimum, although the picture has moved on."""
    level, steady = VerticalDriftFilter(60), VerticalDriftFilter(60)
    for _ in range(20):
        level.remove_drift((0.0, 0.1))
        steady.remove_drift((0.0, 0.1))
    assert level.remove_drift((0.0, 2.0), dt=1e-3) == (0.0, pytest.approx(2.0, abs=0.01))
    assert [level.remove_drift((0.0, dy)) for dy in (2.0, -2.0, 2.0)] == [
        steady.remove_drift((0.0, dy)) for dy in (2.0, -2.0, 2.0)
    ]


@pytest.mark.parametrize("shift", [(0.0, 0.0), (1e-9, 1e-9)])
def test_an_unknown_shift_is_ignored(shift: tuple[float, float]) -> None:
    level = VerticalDriftFilter(60)
    level.remove_drift((0.0, 4.0))
    assert level.remove_drift(shift) == shift
    assert level.remove_drift((0.0, 4.0)) == (0.0, pytest.approx(4.0 - 8.0 / 3))


def test_without_frames_nothing_changes() -> None:
    level = VerticalDriftFilter(0)
    assert [level.remove_drift((1.0, -3.0)) for _ in range(5)] == [(1.0, -3.0)] * 5


def test_the_level_restarts_without_tracks() -> None:
    """A run can thus resume after any frame without tracks."""

    def drive(empty_before: int) -> list[list[float]]:
        tracker = Tracker(TrackingParams(), 640, 360)
        for frame in range(empty_before):
            tracker.step(frame, Detections.empty(), shift=(0.0, 3.0))
        boxes = []
        for frame in range(empty_before, empty_before + 12):
            y = 100.0 + 3 * (frame - empty_before)
            row = np.array([[200.0, y, 230.0, y + 30.0]])
            one = np.ones(1)
            tracked = tracker.step(frame, Detections(row, 2 * one, one, 2 * one), shift=(0.0, 3.0))
            boxes.append(tracked.tracks[0].box.tolist())
        return boxes

    assert drive(0) == drive(25)
