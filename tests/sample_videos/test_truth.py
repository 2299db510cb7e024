"""Ground-truth rows: clipped to the picture, small or hidden faces ignored, files read back."""

from __future__ import annotations

from pathlib import Path

import pytest

from sample_videos.ground_truth import HEADER, Row, make_row, write_csv
from tests.sample_videos.truth_rows import read_rows


def test_a_row_is_clipped_to_the_picture() -> None:
    made = make_row(3, 1, (90.0, -5.0, 130.0, 35.0), (100, 80), 14, 0.4)
    assert made == Row(3, 1, 90.0, 0.0, 100.0, 35.0, 14, 0.4, 0)
    assert make_row(3, 1, (101.0, 10.0, 130.0, 35.0), (100, 80), 14, 0.0) is None


@pytest.mark.parametrize(
    ("side", "visibility", "ignore"), [(11.9, 1.0, 1), (12.1, 1.0, 0), (60.0, 0.34, 1), (60.0, 0.36, 0)]
)
def test_small_and_hidden_faces_are_ignored(side: float, visibility: float, ignore: int) -> None:
    made = make_row(0, 1, (10.0, 10.0, 10.0 + side, 40.0 + side), (640, 480), 2, visibility)
    assert made is not None
    assert made.ignore == ignore


def test_rows_round_trip_through_csv(tmp_path: Path) -> None:
    rows = [Row(0, 1, 1.25, 2.5, 30.75, 40.0, 13, 0.875, 0), Row(9, 2, 0.0, 0.0, 5.5, 6.25, 42, 0.0, 1)]
    write_csv(tmp_path / "t.csv", rows)
    assert (tmp_path / "t.csv").read_text().splitlines()[0] == ",".join(HEADER)
    assert read_rows(tmp_path / "t.csv") == rows
