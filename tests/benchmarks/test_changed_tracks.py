"""Corrections by an annotator who knows the ground truth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.review.changed_tracks import judge
from tsr_engine.track_table import TrackTable

SIGN = (100.0, 100.0, 140.0, 140.0)
OFF = (300.0, 300.0, 340.0, 340.0)
LOOSE = (115.0, 115.0, 155.0, 155.0)
"""IoU of 0.24 with the sign."""


def truth(boxes: list[Any], label: int = 14, ignore: bool = False) -> TrackTable:
    n = len(boxes)
    return TrackTable(
        np.arange(n),
        np.ones(n, np.int64),
        np.array(boxes, float),
        np.full(n, label),
        ignore=np.full(n, ignore),
    )


def tracks(*of: list[Any]) -> TrackTable:
    rows = sorted((frame, track, box) for track, boxes in enumerate(of) for frame, box in enumerate(boxes) if box)
    n = len(rows)
    return TrackTable(
        np.array([row[0] for row in rows]),
        np.array([row[1] for row in rows]),
        np.array([row[2] for row in rows], float),
        np.zeros(n, np.int64),
        names=tuple(f"m{i}" for i in range(len(of))),
    )


def judged(found: TrackTable, known: TrackTable, *labels: int) -> tuple[str | None, ...]:
    return judge(found, np.array(labels or [14]), known, (640, 480))


@pytest.mark.parametrize(
    ("boxes", "change"),
    [
        ([SIGN] * 20, ""),
        ([SIGN] * 19 + [LOOSE], ""),
        ([SIGN] * 17 + [LOOSE] * 3, "boxes"),
        ([SIGN] * 17 + [OFF] * 3, "boxes"),
        ([OFF] * 20, "false"),
    ],
)
def test_boxes_off_the_sign_are_corrected_or_the_track_is_false(boxes: list[Any], change: str) -> None:
    assert judged(tracks(boxes), truth([SIGN] * 20)) == (change,)


def test_another_label_is_changed() -> None:
    assert judged(tracks([SIGN] * 20), truth([SIGN] * 20), 13) == ("label",)


def test_two_tracks_of_one_sign_are_joined() -> None:
    found = tracks([SIGN] * 9 + [None] * 11, [None] * 9 + [SIGN] * 11)
    assert judged(found, truth([SIGN] * 20), 14, 14) == ("split", "split")
    assert judged(found, truth([SIGN] * 20), 14, 13) == ("split", "label")


def test_ignored_ground_truth_is_not_judged() -> None:
    assert judged(tracks([SIGN] * 20), truth([SIGN] * 20, ignore=True)) == (None,)


def test_boxes_at_the_edge_are_not_corrected() -> None:
    edge = (610.0, 100.0, 639.0, 140.0)
    assert judged(tracks([SIGN] * 12 + [edge] * 8), truth([SIGN] * 12)) == ("",)
