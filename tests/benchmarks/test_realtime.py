"""The report on the preset ``realtime``."""

from __future__ import annotations

import re

import numpy as np
import pytest

from benchmarks.experiment import ROOT, Result
from benchmarks.experiments import realtime
from tsr_engine.track_table import TrackTable


def _approach(sign: int, first: int, left: float) -> TrackTable:
    """A sign that grows by a px a frame from 20 px on, from frame ``first`` to 9."""
    frames = np.arange(first, 10)
    boxes = np.array([[left, 40.0, left + 20 + k, 60.0 + k] for k in frames])
    return TrackTable(frames, np.full(len(frames), sign), boxes, np.zeros(len(frames), int))


def _together(*tables: TrackTable) -> TrackTable:
    columns = ("frame", "track", "boxes", "class_id")
    return TrackTable(*(np.concatenate([getattr(table, name) for table in tables]) for name in columns))


def test_first_sight_is_the_first_frame_of_a_matching_track() -> None:
    truth = _together(_approach(1, 0, 100.0), _approach(2, 0, 300.0))
    found = realtime.first_frames(truth, _approach(7, 3, 100.0), 10, (640, 480))
    assert found == {1: (3, 23.0)}


def test_signs_seen_later_or_missed_are_counted() -> None:
    before = {("a", 1): (0, 20.0), ("a", 2): (4, 24.0), ("b", 1): (5, 30.0)}
    now = {("a", 1): (2, 22.0), ("a", 2): (4, 24.0), ("b", 2): (1, 21.0)}
    assert realtime.delays(before, now) == {
        "first_seen_width": 23.0, "later_mean": 1.0, "later_most": 2, "lost": [["b", 1]], "won": [["b", 2]],
    }  # fmt: skip
    assert realtime.delays({}, {})["later_mean"] is None


def test_the_time_of_a_frame_is_the_mean_over_a_cycle_of_bands() -> None:
    assert realtime.steady_seconds([1.0, 4.0, 1.0, 4.0, 1.0, 400.0], 2) == pytest.approx(2.5)


def test_two_cores_are_limited_by_the_sequential_part() -> None:
    shared = {"whole": 40.0, "detection": 25.0, "decoding": 5.0}
    in_order = {"whole": 40.0, "detection": 5.0, "decoding": 5.0}
    assert realtime.frames_a_second(shared) == pytest.approx(1e3 / (20 + realtime.PASSING))
    assert realtime.frames_a_second(in_order) == pytest.approx(1e3 / (30 + realtime.PASSING))


def test_the_stored_result_is_reported_with_its_bars() -> None:
    text = realtime.EXPERIMENT.report(Result.load(ROOT / "results" / "realtime.json"))
    assert not re.search(r"\| -\d", text), "no time or count is below zero"
    assert text.count(" (met)") + text.count("**missed**") == 2 * len(realtime.SIZES)
