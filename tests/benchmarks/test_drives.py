"""First sight of signs, and drives in other weather: counts and report."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.corruptions.weather import WEATHERS
from benchmarks.experiment import Result
from benchmarks.experiments import drives, first_sight
from tsr_engine.track_table import TrackTable


def _table(*rows: tuple[int, int, float]) -> TrackTable:
    """Rows of frame, track and width; all boxes share their upper left corner."""
    frame, track, width = (np.array(column) for column in zip(*rows, strict=True))
    boxes = np.stack([np.full(len(rows), 10.0), np.full(len(rows), 20.0), 10 + width, 20 + width], axis=1)
    return TrackTable(frame, track, boxes, np.ones(len(rows), np.int64))


def test_first_sight_is_the_first_frame_of_a_matching_track() -> None:
    truth = _table((0, 7, 14.0), (1, 7, 16.0), (2, 7, 18.0), (9, 8, 40.0), (3, 9, 30.0))
    truth = replace(truth, ignore=np.array([True, True, False, False, True]))
    results = _table((0, 1, 4.0), (1, 1, 15.0), (2, 1, 18.0))
    assert first_sight.first_widths(truth, results, 10) == {7: 16.0, 8: None}


def test_widths_are_compared_over_the_signs_that_both_find() -> None:
    rows = [
        {"before": 20.0, "now": 16.0, "least": 12.0},
        {"before": 20.0, "now": 25.0, "least": 20.0},
        {"before": 20.0, "now": 20.0, "least": 20.0},
    ]
    found = first_sight.compare_widths([*rows, {"before": None, "now": 30.0, "least": 12.0}], 0)
    assert (found["signs"], found["found"]) == (4, {"before": 3, "now": 4})
    assert (found["earlier"], found["later"], found["at_once"]) == (1, 1, 1)
    assert found["ratio"] == pytest.approx(1.0)
    assert found["interval"] == pytest.approx([0.8, 1.25])
    assert "ratio" not in first_sight.compare_widths([{"before": None, "now": 30.0, "least": 12.0}], 0)


def test_the_report_names_signs_that_differ() -> None:
    rows = [
        {"clip": "a", "sign": 1, "before": 20.0, "now": 30.0, "least": 12.0},
        {"clip": "b", "sign": 2, "before": 20.0, "now": 20.5, "least": 12.0},
        {"clip": "c", "sign": 3, "before": 20.0, "now": None, "least": 12.0},
    ]
    text = first_sight.EXPERIMENT.report(
        Result(
            "first_sight",
            figures={"approaches": first_sight.compare_widths(rows, 0) | {"rows": rows}},
            settings={"before": "8b1", "now": "d79"},
        )
    )
    assert "- a: sign 1: 20.0 px before, 30.0 px now." in text
    assert "- c: sign 3: 20.0 px before, not found now." in text
    assert "- b" not in text
    assert "| approaches | 3 | 3, 2 | 0 | 20.0, 25.2 px | 1.240 |" in text


def test_a_rate_comes_with_its_interval() -> None:
    assert drives.rate(0, 1000) == pytest.approx((0.0, 0.0, 3.689), abs=1e-3)
    assert drives.rate(3, 2000) == pytest.approx((1.5, 0.3093, 4.3837), abs=1e-3)


def test_every_track_of_a_drive_is_reported() -> None:
    track = {"drive": "a", "first": 3, "last": 9, "class": 14, "width": 21.4, "on_sign": False}
    figures = {
        "as recorded": {"frames": 500, "drives": 2, "tracks": [track | {"on_sign": True}]},
        "rain": {"frames": 500, "tracks": [track, track | {"on_sign": True}]},
    }
    text = drives.EXPERIMENT.report(Result("drives", figures=figures))
    assert "| as recorded | 500 | 1 | 0 | 0.00 | 0.00 to 7.38 |" in text
    assert "| rain | 500 | 2 | 1 | 2.00 | 0.05 to 11.14 |" in text
    assert "- as recorded, a: frames 3 to 9, up to 21 px wide, read as stop." in text
    assert "- rain, a: frames 3 to 9, up to 21 px wide, read as stop, on no sign." in text


def test_boxes_of_seen_signs_are_linear_between_the_stored_ones() -> None:
    table = drives.boxes_between([{"4": [0, 0, 10, 10], "6": [4, 2, 16, 14]}, {"9": [1, 2, 3, 4]}])
    assert table.frame.tolist() == [4, 5, 6, 9]
    assert table.track.tolist() == [0, 0, 0, 1]
    assert table.boxes[1].tolist() == [2.0, 1.0, 13.0, 12.0]
    assert len(drives.boxes_between([])) == 0


@pytest.mark.parametrize("name", WEATHERS)
def test_weather_is_reproducible_and_resumes(name: str) -> None:
    picture = np.random.default_rng(0).integers(60, 255, (45, 80, 3), np.uint8)
    first, again, later = (WEATHERS[name](picture.copy(), ordinal) for ordinal in (4, 4, 5))
    assert first.shape == picture.shape
    assert first.dtype == np.uint8
    np.testing.assert_array_equal(first, again)
    assert (first != later).any()
    assert (first.mean() < 0.5 * picture.mean()) == (name in ("darkened", "night"))
